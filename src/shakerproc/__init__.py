"""From shaker recordings to the physical effect that the model left out."""

__version__ = "0.1.0"
