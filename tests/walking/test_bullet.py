"""PyBullet works and keeps silent."""

import subprocess
import sys

WORLD = """
from footsel.walking.bullet import BulletWorld
world, other = BulletWorld(), BulletWorld()
world.createMultiBody(1.0)
assert (world.getNumBodies(), other.getNumBodies()) == (1, 0)
world.disconnect()
assert other.getNumBodies() == 0
"""
CHATTER = """
import pybullet
from pybullet_utils.bullet_client import BulletClient
BulletClient(pybullet.DIRECT)
"""


def output(code: str) -> str:
    """What a fresh interpreter prints."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def test_worlds_are_their_own_and_say_nothing():
    assert output(WORLD) == ""


def test_pybullet_alone_would_say_something():
    assert "argv[0]" in output(CHATTER) and "build time" in output(CHATTER)


def test_what_we_write_to_stderr_stays():
    said = output("import sys, footsel.walking.bullet; print('ours', file=sys.stderr)")
    assert said == "ours\n"
