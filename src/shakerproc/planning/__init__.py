"""Before the test: displacement against clearance, contents of a recording, rehearsal."""

from shakerproc.planning.acquisition import (
    Averaging,
    averaging,
    duration_of_test,
    sample_rate_of_test,
)
from shakerproc.planning.joints import (
    AbstractJoint,
    FreeJoint,
    JointMode,
    ModelJoint,
    Play,
    Walls,
    Warming,
    joint_of_model,
    play_of_test,
)
from shakerproc.planning.plan import (
    BaseTravel,
    Needed,
    PlannedTest,
    PlanWish,
    bands_text,
    plan_columns,
    plan_documents,
)
from shakerproc.planning.planned import displacement_of_test, plan_campaign, plan_test
from shakerproc.planning.reach import (
    Reach,
    bands_above,
    bands_within_limits,
    curve,
    frequencies_of,
    reach,
)
from shakerproc.planning.rehearsal import (
    Rehearsed,
    Staging,
    rehearse,
    respond,
    with_usual_roles,
)
from shakerproc.planning.shaker import (
    AbstractInput,
    RandomInput,
    ShakerLimits,
    SineInput,
    TableMotion,
    input_of_test,
)
from shakerproc.planning.suggested import suggested_tests
from shakerproc.spectra.tones.passing import fastest_rate, swept_peak

__all__ = [
    "AbstractInput",
    "AbstractJoint",
    "Averaging",
    "BaseTravel",
    "FreeJoint",
    "JointMode",
    "ModelJoint",
    "Needed",
    "PlanWish",
    "PlannedTest",
    "Play",
    "RandomInput",
    "Reach",
    "Rehearsed",
    "ShakerLimits",
    "SineInput",
    "Staging",
    "TableMotion",
    "Walls",
    "Warming",
    "averaging",
    "bands_above",
    "bands_text",
    "bands_within_limits",
    "curve",
    "displacement_of_test",
    "duration_of_test",
    "fastest_rate",
    "frequencies_of",
    "input_of_test",
    "joint_of_model",
    "plan_campaign",
    "plan_columns",
    "plan_documents",
    "plan_test",
    "play_of_test",
    "reach",
    "rehearse",
    "respond",
    "sample_rate_of_test",
    "suggested_tests",
    "swept_peak",
    "with_usual_roles",
]
