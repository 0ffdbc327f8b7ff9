"""The array job, run by a Slurm cluster of one node."""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import FRAMES
from slurm_node import SlurmNode, missing

SCRIPT = Path(__file__).resolve().parents[1] / "seidel-apply.slurm.sh"


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SlurmNode]:
    if missing():
        pytest.skip(missing())
    node = SlurmNode(tmp_path_factory.mktemp("slurm"))
    try:
        if not node.is_ready(30):
            pytest.skip(f"no Slurm node can be started here: {node.logs()[-400:]}")
        yield node
    finally:
        node.stop()


def submit(cluster: SlurmNode, seidel: str, folder: Path, frames: str) -> tuple[list[str], str]:
    """Submits the shot; returns the states of its tasks and their logs."""
    submitted = cluster.command(
        str(SCRIPT),
        frames,
        "5",
        str(folder / "lens.json"),
        str(folder / "plates/plate.%04d.exr"),
        str(folder / "out/blurred.%04d.exr"),
        *["--focus-distance", "3", "--f-number", "f/2", "--quality", "draft"],
        SEIDEL_COMMAND=seidel,
        SBATCH_PARTITION="main",
    )
    assert submitted.returncode == 0, submitted.stderr
    job = submitted.stdout.split()[-1]
    states = cluster.states(job, 120)
    logs = [cluster.folder / f"seidel-apply.{job}_{task}.log" for task in range(len(states))]
    return states, "".join(log.read_text() for log in logs)


def test_a_bad_frame_fails_alone_and_the_same_line_goes_on(
    cluster: SlurmNode, seidel: str, demo: Path, tmp_path: Path
) -> None:
    shutil.copy(demo / "lens.json", tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "plates").mkdir()
    for frame in FRAMES:
        shutil.copy(demo / "plate.exr", tmp_path / "plates" / f"plate.{frame:04}.exr")
    bad = tmp_path / "plates" / "plate.1006.exr"
    bad.write_bytes(b"no picture")
    # The last task has two frames.
    states, log = submit(cluster, seidel, tmp_path, "1001-1012")
    assert states == ["COMPLETED", "FAILED", "COMPLETED"], log
    assert "1 of 5 frames failed" in log and "plate.1006.exr" in log
    written = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert written == [f"blurred.{frame}.exr" for frame in FRAMES if frame != 1006]

    shutil.copy(demo / "plate.exr", bad)
    states, log = submit(cluster, seidel, tmp_path, "1001-1012")
    assert states == ["COMPLETED"] * 3, log
    assert log.count("wrote ") == 1 and "blurred.1006.exr" in log


@pytest.mark.parametrize("arguments", [[], ["a-b", "5"], ["9-1", "5"], ["1-9", "0"]])
def test_wrong_lines_are_refused_before_anything_is_submitted(arguments: list[str]) -> None:
    line = [*arguments, *["x"] * (5 - len(arguments))] if arguments else []
    refused = subprocess.run(["bash", SCRIPT, *line], capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "usage:" in refused.stderr, refused.stderr
