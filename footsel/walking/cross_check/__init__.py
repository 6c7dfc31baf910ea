"""The oracle's collisions checked by others: PyBullet with the same primitives, coal with the robot's full meshes.

python -m footsel.walking.cross_check contacts [MAPS...] --out contacts.json
python -m footsel.walking.cross_check meshes [MAPS...] --out meshes.json
"""
