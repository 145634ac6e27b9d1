"""The compiled force laws, one file each, and the table in which the steppers look them up."""
