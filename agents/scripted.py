"""Which scripted controller does which task."""

from collections.abc import Sequence

from coopenv.config import TransportConfig
from coopenv.tasks import DoorwayTask, TrackingTask

from .controllers import Gains, ImpedanceController
from .controllers_doorway import DoorwayController
from .controllers_tracking import TrackingController

# The first whose task it is; any other task is left to the impedance controller.
CONTROLLERS: dict[type, type[ImpedanceController]] = {
    DoorwayTask: DoorwayController,
    TrackingTask: TrackingController,
}


def find_controller(
    config: TransportConfig,
    *,
    method: str = "moore_penrose",
    virtual_masses: Sequence[float] | None = None,
    virtual_inertias: Sequence[float] | None = None,
    gains: Gains | None = None,
) -> ImpedanceController:
    """The scripted controller for the task of ``config``; arguments as for that.

    Raises
    ------
    UnknownName
        If the method does not exist.
    """
    kind = next(
        (kind for task, kind in CONTROLLERS.items() if isinstance(config.task, task)),
        ImpedanceController,
    )
    return kind(
        config,
        method=method,
        virtual_masses=virtual_masses,
        virtual_inertias=virtual_inertias,
        gains=gains,
    )
