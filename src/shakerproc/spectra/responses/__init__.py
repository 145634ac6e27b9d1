"""Response functions and coherences from the matrix of cross spectra."""
