"""When which leg swings, where it goes and how it gets there."""
