"""Coupon modes and static stiffness of holes, by closed forms and finite elements."""
