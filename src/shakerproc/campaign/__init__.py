"""Many runs: isolated, resumable, with a manifest of inputs and outputs."""
