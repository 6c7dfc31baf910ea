"""The fast oracle held against the brute-force reference, cell by cell.

`python -m footsel.oracle.verification [MAPS...] --out verify.json` does it on every course family and the given maps.
"""
