"""What the next level does: forecasts of planned tests, with bands that were earned."""

from shakerproc.forecast.document import document_of
from shakerproc.forecast.forecast import Evidence, Forecast, TestForecast, forecast_tests
from shakerproc.forecast.quantities import Quantity
from shakerproc.forecast.sentences import headline, sentences

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
