"""Walks with different selectors compared: success rates, paired differences, and the report on them."""
