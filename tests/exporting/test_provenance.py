"""Which commit a file names."""

import re
import subprocess

import footsel
from footsel.exporting.provenance import source_commit


def git(folder, *arguments):
    identity = ["-c", "user.name=n", "-c", "user.email=e@example.org"]
    return subprocess.run(["git", "-C", folder, *identity, *arguments], check=True, capture_output=True, text=True)


def test_the_commit_of_a_checkout_and_whether_it_was_edited(tmp_path):
    git(tmp_path, "init")
    (tmp_path / "file").write_text("one")
    git(tmp_path, "add", "file")
    git(tmp_path, "commit", "--message", "one")
    git(tmp_path, "tag", "v1")
    commit = source_commit(tmp_path)
    assert re.fullmatch("[0-9a-f]{40}", commit)
    assert commit == git(tmp_path, "rev-parse", "HEAD").stdout.strip()
    (tmp_path / "file").write_text("two")
    assert source_commit(tmp_path) == f"{commit}-dirty"


def test_an_installed_package_names_its_version(tmp_path):
    """Also inside of a repository, which is another's."""
    git(tmp_path, "init")
    (tmp_path / "site-packages").mkdir()
    assert source_commit(tmp_path / "site-packages") == footsel.__version__


def test_a_repository_that_git_cannot_read_is_none(tmp_path):
    (tmp_path / ".git").write_text("damaged")
    assert source_commit(tmp_path) == footsel.__version__
