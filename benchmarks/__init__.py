"""What the issues promise of speed, memory and accuracy, measured: `python -m benchmarks`."""
