"""Figures of models and of tests that are planned: effects, studies, responses, coupons."""
