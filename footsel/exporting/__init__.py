"""From a training run to a released model folder: ONNX, checksums, parity report and model card.

Importing this package alone loads neither torch nor onnx.
"""
