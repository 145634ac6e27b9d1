"""TDMS: a walk over the segments first, npTDMS for properties and scaling, own block reads."""
