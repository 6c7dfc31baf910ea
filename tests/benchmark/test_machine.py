"""What a machine is called beside its figures."""

import pytest

from footsel.benchmark.machine import cpu_name

CPUINFO = """processor\t: 0
model name\t: Fast Chip
flags\t\t: fpu sse4_2 {flags}

processor\t: 1
model name\t: Slow Chip
flags\t\t: fpu
"""


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        ("avx avx2 avx512f avx512_bf16", "Fast Chip with AVX-512"),
        ("avx avx2", "Fast Chip with AVX2"),
        ("", "Fast Chip"),
    ],
)
def test_a_chip_is_called_by_what_it_computes_with(tmp_path, flags, expected):
    """A network takes several times as long on one without AVX-512, and virtual machines give both the same name."""
    path = tmp_path / "cpuinfo"
    path.write_text(CPUINFO.format(flags=flags))
    assert cpu_name(path) == expected


def test_another_system_still_has_a_name(tmp_path):
    assert cpu_name(tmp_path / "missing")
