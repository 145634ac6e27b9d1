"""Numbers of a model fitted to the levels that were run, to whole tests at once if possible."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from shakerproc.comparison import Measured
from shakerproc.diagnosis.campaign import campaign_of, own_numbers
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.data.from_files import arrays
from shakerproc.diagnosis.estimation.form import carried, usable_forms
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.passed_noise import with_passed_noise
from shakerproc.diagnosis.estimation.sampling import as_recorded
from shakerproc.diagnosis.fitted_numbers import fit_of
from shakerproc.diagnosis.horizon import is_mostly_noise
from shakerproc.models import Model


def fit_of_levels(
    model: Model, tests: Sequence[Measured], say: Callable[[str], None] = lambda _text: None
) -> Fit:
    """Return the fit of a model's numbers to tests, its effects as they are.

    What short windows tell is carried over to the longest horizon at once. Where that leaves
    no more than noise, no horizon in between says more; else each is tried (see `fit_of`), as
    `diagnose` does: a long one alone is full of local minima.

    Parameters
    ----------
    model : Model
        The model.
    tests : sequence of Measured
        Those that may be fitted to.
    say : callable
        Called with what is being done.
    """
    known = replace(model, sensors={name: model.sensors[name] for name in tests[0].sensors})
    campaign = campaign_of(known, prepared([arrays(test) for test in tests]))
    if not known.structures:  # of these there is one horizon
        say(f"numbers fitted to test {', '.join(test.name for test in tests)}")
        alone = own_numbers(campaign)
        form = usable_forms(campaign.data)[-1]
        data = as_recorded(campaign.data, alone)
        longest = replace(form, fitted=with_passed_noise(data, alone, form.fitted))
        fit = carried(data, alone, [longest])
        if fit is not None and is_mostly_noise(replace(campaign, data=data), fit):
            return fit
    return fit_of(model, tests, say)
