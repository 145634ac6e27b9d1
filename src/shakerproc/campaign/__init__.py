"""Many runs: isolated, resumable, with a manifest of what was made from what."""
