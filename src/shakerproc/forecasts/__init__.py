"""Forecasts of planned tests, with bands that were earned on the levels that were run."""

from shakerproc.forecasts.document import document_of, headline, sentences
from shakerproc.forecasts.forecast import (
    CampaignForecast,
    ModelEvidence,
    TestForecast,
    forecast_tests,
)
from shakerproc.forecasts.quantities import Quantity
