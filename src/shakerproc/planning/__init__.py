"""Before the test: displacement against clearance, contents of a recording, rehearsal."""

from shakerproc.planning.drive import averaging
from shakerproc.planning.joints import (
    AbstractJoint,
    FreeJoint,
    Walls,
    Warming,
    joint_of_model,
    play_of_test,
)
from shakerproc.planning.plan import (
    PlannedTest,
    PlanWish,
    bands_text,
    plan_columns,
    plan_documents,
    suggested_tests,
)
from shakerproc.planning.planned import displacement_of_test, plan_campaign, plan_test
from shakerproc.planning.reach import bands_within_limits, curve, frequencies_of, reach
from shakerproc.planning.rehearsal import Staging, rehearse, respond, with_usual_roles
from shakerproc.planning.shaker import (
    AbstractInput,
    RandomInput,
    ShakerLimits,
    SineInput,
    input_of_test,
)
from shakerproc.spectra.tones.passing import fastest_rate, swept_peak
