"""The statements of the thesis, each with the number that the program finds for it."""
