"""A shot of 12 frames, and the runner of Open Job Description."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

TEMPLATE = Path(__file__).resolve().parents[1] / "seidel-apply.openjd.yaml"
FRAMES = range(1001, 1013)


def program(name: str, variable: str, remedy: str) -> str:
    """Returns the path of a program: that in an environment variable, beside Python, or on the path."""
    beside = Path(sys.executable).with_name(name)
    found = os.environ.get(variable) or (str(beside) if beside.is_file() else shutil.which(name))
    if not found:
        pytest.skip(f"{name} is not there: {remedy}")
    return found


@pytest.fixture(scope="session")
def openjd() -> str:
    return program("openjd", "OPENJD_COMMAND", "pip install openjd-cli")


@pytest.fixture(scope="session")
def seidel() -> str:
    return program("seidel", "SEIDEL_COMMAND", "set SEIDEL_COMMAND to the command seidel")


@dataclass(frozen=True)
class Shot:
    """The files of a shot, and the programs that render it."""

    folder: Path
    openjd: str
    seidel: str

    def output(self, frame: int) -> Path:
        return self.folder / "out" / f"blurred.{frame:04}.exr"

    def finished(self) -> list[int]:
        return [frame for frame in FRAMES if self.output(frame).is_file()]

    def run(self, *options: str, **parameters: str) -> subprocess.CompletedProcess[str]:
        """Runs the job; `options` go to the runner."""
        values = {
            "Lens": self.folder / "lens.json",
            "PlateFolder": self.folder / "plates",
            "OutputFolder": self.folder / "out",
            "Frames": "1001-1012",
            "ChunkSize": "4",
            "Memory": "500M",
            "Options": "--focus-distance 3 --f-number f/2 --quality draft",
            "Program": self.seidel,
            **parameters,
        }
        command = [self.openjd, "run", str(TEMPLATE), *options]
        for name, value in values.items():
            command += ["-p", f"{name}={value}"]
        return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="session")
def demo(seidel: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demo") / "demo"
    subprocess.run([seidel, "demo", folder, "--width", "128"], check=True, capture_output=True)
    return folder


@pytest.fixture
def shot(openjd: str, seidel: str, demo: Path, tmp_path: Path) -> Shot:
    shutil.copy(demo / "lens.json", tmp_path / "lens.json")
    (tmp_path / "out").mkdir()
    (tmp_path / "plates").mkdir()
    for frame in FRAMES:
        shutil.copy(demo / "plate.exr", tmp_path / "plates" / f"plate.{frame:04}.exr")
    return Shot(tmp_path, openjd, seidel)
