"""``coopenv replay``: a policy's episode, or a recorded trial, as a film beside its time series."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.agents.environment import EnvironmentChoice
from coopenv.agents.pretrained.naming import is_name
from coopenv.agents.seeds import evaluation_seeds
from coopenv.agents.trained.form import is_plain
from coopenv.arrays import positive, whole
from coopenv.cli import trial
from coopenv.cli.environments import RECORDED, environments_of
from coopenv.cli.policies import find_policy
from coopenv.cli.trial import Shown
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import require_file, require_writable
from coopenv.options import POSITIONAL, Common

if TYPE_CHECKING:
    from coopenv.render.film import Frames
    from coopenv.render.replay import Pace
    from coopenv.transition import Transition

RATES = 1.0, 240.0  # [1/s] of pictures
MOST_WORLDS = 64  # of a mosaic
OF_EPISODES = ("seed", "episode", "mosaic", "trust")
OF_LAYOUTS = ("grips", "space", "sample_rate")
OF_RECORDINGS = ("trial", "start", "end", "layout", "map", *OF_LAYOUTS, "bad_rows")


@dataclass(frozen=True, kw_only=True)
class Replay:
    """Film a held-out episode of a policy, or a recorded trial, with γ, F_I, T_I and shares."""

    what: Annotated[str, POSITIONAL]
    """A policy as coopenv evaluate takes it (scripted, random, policy.zip,
    pretrained:BeamDoorway/joint), or the file of a recording, in the plane or in space, as
    coopenv decompose reads it."""
    environment: EnvironmentChoice = field(default_factory=lambda: EnvironmentChoice(env=RECORDED))
    seed: int = 0
    """Of a policy: number of the evaluation; see coopenv.agents.seeds."""
    episode: int = 1
    """Of a policy: which of the evaluation's episodes; the first is 1."""
    mosaic: int = 1
    """Of a policy: so many episodes from that one on, side by side."""
    trust: bool = False
    """Of a policy: run what its file holds, and import the module of its environment."""
    trial: int = 1
    """Of a recording: which trial; the first is 1."""
    start: float = 0.0
    """Of a recording: since the trial began [s]."""
    end: float | None = None
    """Of a recording: likewise [s]; all of the trial by default."""
    layout: Path | None = None
    """Of a recording: .toml or .json file that says how it is to be read; see
    docs/recordings.md."""
    map: tuple[str, ...] = ()
    """Of a recording: columns that are called otherwise, such as f1x=Fx_left; time= leaves one
    out."""
    grips: tuple[float, ...] | None = None
    """Of a recording: x y (in space x y z) of the first effector, then of the second; object frame
    [m]."""
    space: str | None = None
    """Of a recording: plane leaves out what points out of it."""
    sample_rate: float | None = None
    """Of a recording without times: rows a second [Hz]."""
    bad_rows: str = "error"
    """Of a recording: what to do with rows that cannot be used: error, or skip (gaps)."""
    speed: float = 1.0
    """How many times faster than life."""
    fps: float = 20.0
    """Pictures a second; a GIF has at most 50, and whole hundredths of a second between them."""
    series: bool = True
    """Show γ, F_I, T_I and load shares beside the scene, of a mosaic beside each."""
    width: int = 480
    """Of the scene [px]; the time series beside it have 0.85 of it."""
    out: Path | None = None
    """Film, .gif or .mp4; replay.gif, or trial.replay.gif beside trial.csv by default."""

    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv replay scripted --env coopenv/BeamDoorway-v0 --partner follower",
        "coopenv replay runs/policy.zip --episode 3 --out episode.mp4",
        "coopenv replay scripted --mosaic 9 --width 240 --no-series",
        "coopenv replay trial.csv --grips -0.9 0 0.9 0 --speed 0.5 --start 2 --end 8",
    )

    def run(self) -> dict[str, Any]:
        """Run or read, draw, write."""
        try:
            from rich.console import Console
        except ImportError as error:
            raise MissingExtra("coopenv replay", "train") from error

        from coopenv.render.film import require_film, save_film
        from coopenv.render.replay import LEAST, MOST

        console = Console()
        of_policy = self._is_of_policy()
        out = self.out if self.out is not None else self._default_out(of_policy)
        require_film(out)
        require_writable(out)
        whole(self.width, "width", at_least=LEAST, at_most=MOST)
        pace = self._pace(out)
        frames, shown = self._of_policy(pace) if of_policy else self._of_recording(pace)
        with _progress() as report:
            save_film(out, frames, fps=pace.fps, report=report)
        for line in (*shown.lines, f"wrote {out}, {len(frames)} pictures, {pace.fps:g} a second"):
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        return {"shown": shown.document, "film": out, "pictures": len(frames), "fps": pace.fps}

    def _is_of_policy(self) -> bool:
        """Whether a policy is named; raise where options are of the other kind."""
        path = Path(self.what)
        kind = self.what.partition(":")[0]
        named = kind in ("random", "scripted") or is_name(self.what)
        of_policy = named or path.suffix == ".zip" or path.is_dir() or is_plain(path)
        if not of_policy and not path.exists():
            raise InvalidInput(
                "what must be a policy (scripted, random, pretrained:BeamDoorway/joint, the .zip "
                f"or .npz of a trained one) or the file of a recording, got {self.what!r}; check "
                "its name"
            )
        default = Replay(what=self.what)
        others = OF_RECORDINGS if of_policy else (*OF_EPISODES, "environment")
        for name in others:
            if getattr(self, name) != getattr(default, name):
                kinds = ("policy", "recording") if of_policy else ("recording", "policy")
                said = "options of the environment" if name == "environment" else name
                raise InvalidInput(
                    f"{said} must be left out beside a {kinds[0]}, got them for {self.what!r}; "
                    f"they say something of a {kinds[1]}"
                )
        return of_policy

    def _default_out(self, of_policy: bool) -> Path:
        file = Path(self.what)
        return Path("replay.gif") if of_policy else file.with_name(f"{file.stem}.replay.gif")

    def _pace(self, out: Path) -> "Pace":
        from coopenv.render.film import FASTEST, gif_rate
        from coopenv.render.replay import Pace

        fps, speed = positive(self.fps, "fps"), positive(self.speed, "speed")
        if not RATES[0] <= fps <= RATES[1]:
            raise InvalidInput(
                f"fps must be from {RATES[0]:g} to {RATES[1]:g}, got {fps:g}; --speed makes a film "
                "slower or faster"
            )
        if out.suffix.lower() == ".mp4":
            return Pace(fps, speed)
        if fps > FASTEST:
            raise InvalidInput(
                f"fps must be at most {FASTEST:g} in a GIF, got {fps:g}; write an .mp4, or fewer"
            )
        return Pace(gif_rate(fps), speed)

    def _of_policy(self, pace: "Pace") -> tuple["Frames", Shown]:
        """An episode, or several in a mosaic."""
        from rich.console import Console

        from coopenv.agents.record import episode_steps
        from coopenv.agents.training.threads import torch_threads
        from coopenv.render.replay import film_of_episode, film_of_episodes

        first = whole(self.episode, "episode", at_least=1)
        count = whole(self.mosaic, "mosaic", at_least=1, at_most=MOST_WORLDS)
        evaluation_seeds(self.seed, first + count - 1)
        places, notes = environments_of({self.what: self.what}, self.environment, self.trust)
        place = places[self.what]
        title, errors = place.title(self.trust), Console(stderr=True)
        for note in notes:
            errors.print(note, markup=False, soft_wrap=True)
        policy = find_policy(self.what, place.config, trust=self.trust)
        with errors.status("running"), torch_threads(1):
            episodes = [
                episode_steps(policy, place.config, seed=self.seed, episode=first + k)
                for k in range(count)
            ]
        shown = _shown_episodes(episodes, first, self.seed, f"{self.what} in {title}")
        how: dict[str, Any] = {"pace": pace, "width": self.width, "series": self.series}
        if count > 1:
            return film_of_episodes(episodes, **how), shown
        return film_of_episode(episodes[0], **how), shown

    def _of_recording(self, pace: "Pace") -> tuple["Frames", Shown]:
        """A trial of a recording."""
        from coopenv.logs.layout import Layout, parse_mapping

        file = Path(self.what)
        require_file(file)
        named = {name: getattr(self, name) for name in OF_LAYOUTS}
        said = {name: value for name, value in named.items() if value is not None}
        layout = Layout.load(self.layout, columns=parse_mapping(self.map), **said)
        chosen = trial.Part(number=self.trial, start=self.start, end=self.end)
        how: dict[str, Any] = {"width": self.width, "series": self.series}
        return trial.film(file, layout, chosen, pace, bad_rows=self.bad_rows, **how)


def _shown_episodes(
    episodes: "Sequence[Sequence[Transition]]", first: int, seed: int, title: str
) -> Shown:
    """How each ended, in words and for programs."""
    said, rows = [title], []
    for number, steps in enumerate(episodes, first):
        last = steps[-1]
        success, seconds = bool(last.success[0]), float(last.next_state.time[0])
        how = "success" if success else "no success"
        when = f"{how} after {seconds:.2f} s, {len(steps) - 1} steps"
        said.append(f"episode {number} of evaluation {seed}: {when}")
        ending = {"success": success, "seconds": seconds, "steps": len(steps) - 1}
        rows.append({"episode": number, **ending})
    return Shown(said, {"policy": title, "seed": seed, "episodes": rows})


@contextmanager
def _progress() -> "Iterator[Callable[[float], None]]":
    """A progress bar over the pictures."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console: Console = Console(stderr=True)
    columns = (TextColumn("drawing"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda done: bar.update(task, completed=done)
