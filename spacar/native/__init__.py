"""Libraries compiled on this machine: found, checked, kept. For the compiled right-hand side and symbolic models."""
