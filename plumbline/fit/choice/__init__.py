"""Which distortion model is enough: comparison, recommendation and its reasons."""
