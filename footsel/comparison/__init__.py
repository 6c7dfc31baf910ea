"""Selectors compared on maps, judged by the oracle: the figures, the drawings and the report."""
