"""Kernels that carry the truth from sample to sample."""
