"""Newton's and Euler's laws for recorded rows, under every declaration that is compared."""

from coopenv.logs.consistency.moments import Moments
from coopenv.logs.consistency.signals import FRAMES, Signals
from coopenv.logs.layout import Layout
from coopenv.logs.recording import Recording

AGREES = 0.2  # unexplained share up to which pose and twist tell the same
LEAST_WINDOWS = 12  # fewer are no evidence


class Laws:
    """Sums over windows from which every law can be fitted, whatever was meant by the file.

    Each law is a method that returns the share that it leaves unexplained, in [0, 1].

    Parameters
    ----------
    layout
        What was declared.
    angle
        Factor of the orientation in the plane, for what was declared in the wrong unit.
    """

    def __init__(self, layout: Layout, *, angle: float = 1.0):
        self.angle = angle
        self.num_swapped = 0
        self.has_twist = False
        self._declared = {"wrench": layout.frame, "twist": str(layout.twist_frame)}
        self._moments = {
            "force": Moments(centred=True),
            "torque": Moments(centred=True),
            "power": Moments(centred=False),
            "shift": Moments(centred=False),
            "spin": Moments(centred=False),
        }
        self._names: dict[str, list[str]] = {law: [] for law in self._moments}  # of signals

    def enough(self, law: str) -> bool:
        """Whether there are rows enough for evidence."""
        return self._moments[law].count >= LEAST_WINDOWS

    def velocities(self, twist: str) -> list[str]:
        """Where the velocity can be from: the pose, or a twist in either frame, first ``twist``."""
        known = self._named("force", "momentum ")
        return sorted(known, key=lambda name: name not in ("pose", twist))

    def force(self, frame: str, velocity: str, sign: float, *, spring: bool = False) -> float:
        """Σ f = m dv/dt + friction · v + constant, and + stiffness · x if there is a ``spring``."""
        causes = [f"momentum {velocity}", f"way {velocity}"]
        if spring:
            causes += self._named("force", "place", whole=True)
        return self._moments["force"].fit({frame: sign}, causes)[0]

    def torque(
        self, frame: str, *, force: float, torque: float, swapped: tuple[int, int] = (0, 0)
    ) -> float:
        """Σ r × f + t = dL/dt + friction · ω + constant, with factors of forces and torques."""
        response = {f"lever {frame} {swapped}": force, f"torque {frame}": torque}
        return self._moments["torque"].fit(
            response, [*self._named("torque", "inertia", whole=True), "turn"]
        )[0]

    def power(self, sign: float) -> float:
        """Σ Ė = d/dt (kinetic energy) + friction."""
        causes = [name for name in self._names["power"] if not name.startswith(("work", "weight"))]
        weight = self._named("power", "weight", whole=True)
        return self._moments["power"].fit({"work": sign}, causes, weight)[0]

    def spin(self, sign: float = 1.0) -> tuple[float, float]:
        """Angular velocity of the pose by that of the twist: unexplained share, and their ratio."""
        left, ratio = self._moments["spin"].fit({"pose": sign}, ["twist"])
        return left, float(ratio[0])

    def theta_goes_with_omega(self) -> bool:
        """Whether both tell the same in the unit of this angle, that of omega being alike."""
        left, ratio = self.spin()
        return self.enough("spin") and left < AGREES and 0.7 < ratio / self.angle < 1.4

    def twist_is_in_the_other_frame(self) -> bool:
        """Whether the velocity of the pose is that of the twist in the frame not declared."""
        if not self.enough("shift"):
            return False
        said = self._declared["twist"]
        left = {frame: self._moments["shift"].fit({"pose": 1.0}, [frame])[0] for frame in FRAMES}
        return left[said] > 0.05 and min(left.values()) < 0.1 * left[said]

    def shift(self, sign: float = 1.0) -> tuple[float, float]:
        """Velocity of the pose by that of the twist, as ``spin``; in the frame that suits it."""
        if not self.enough("shift"):
            return 1.0, 1.0
        fits = (self._moments["shift"].fit({"pose": sign}, [frame]) for frame in FRAMES)
        left, ratio = min(fits, key=lambda fit: fit[0])
        return left, float(ratio[0])

    def slower(self, law: str) -> float:
        """The slower of what pose and twist tell, of the law shift [m/s] or spin [rad/s]."""
        moments = self._moments[law]
        told = ("pose", "twist" if law == "spin" else FRAMES[0])
        return min(moments.size(name) for name in told) if self.enough(law) else 0.0

    def speeding(self) -> float:
        """Usual change of velocity from window to window [m/s]; 0 where it is not known."""
        known = self.velocities(self._declared["twist"])
        return self._moments["force"].size(f"momentum {known[0]}") if known else 0.0

    def add(self, segment: Recording, rows: int) -> None:
        """Append rows that follow one another, of which so many make a window."""
        signals = Signals(segment, rows, self._declared, self.angle)
        self.num_swapped, self.has_twist = signals.num_swapped, segment.twist is not None
        for law, moments in self._moments.items():
            made = signals.of(law)
            if made:
                moments.add(made)
                self._names[law] = list(made)

    def _named(self, law: str, start: str, *, whole: bool = False) -> list[str]:
        """Signals of a law that begin so: their whole names, or the rest of them."""
        found = [name for name in self._names[law] if name.startswith(start)]
        return found if whole else [name.removeprefix(start) for name in found]
