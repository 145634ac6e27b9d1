"""What the next level does: forecasts of planned tests, with bands that were earned."""

from shakerproc.forecasts.document import document_of
from shakerproc.forecasts.forecast import Evidence, Forecast, TestForecast, forecast_tests
from shakerproc.forecasts.quantities import Quantity
from shakerproc.forecasts.sentences import headline, sentences

__all__ = [
    "Evidence",
    "Forecast",
    "Quantity",
    "TestForecast",
    "document_of",
    "forecast_tests",
    "headline",
    "sentences",
]
