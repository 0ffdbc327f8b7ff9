"""The job of Open Job Description, checked and run by its official runner."""

import json
import shutil
import subprocess

from conftest import FRAMES, TEMPLATE, Shot

CONFIG = TEMPLATE.parents[1] / "luts" / "config.ocio"


def test_the_template_is_valid(openjd: str) -> None:
    checked = subprocess.run([openjd, "check", TEMPLATE], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_a_bad_frame_fails_alone_and_the_job_goes_on_where_it_stopped(shot: Shot) -> None:
    bad = shot.folder / "plates" / "plate.1006.exr"
    bad.write_bytes(b"no picture")
    # A farm goes on with the other tasks; the runner stops at the first that fails.
    for chunk in ["1001-1004", "1005-1008", "1009-1012"]:
        ended = shot.run("--step", "Apply", "--task-param", f"Frames={chunk}")
        log = ended.stdout + ended.stderr
        assert (ended.returncode == 0) == (chunk != "1005-1008"), log
        if ended.returncode != 0:
            assert "openjd_fail: 1 of 4 frames failed" in log and "plate.1006.exr" in log, log
        assert "openjd_progress: 75" in log, log
    assert shot.finished() == [frame for frame in FRAMES if frame != 1006]
    assert not list((shot.folder / "out").glob(".*")), "no partial files"

    shutil.copy(shot.folder / "plates" / "plate.1005.exr", bad)
    before = {frame: shot.output(frame).stat().st_mtime_ns for frame in shot.finished()}
    ended = shot.run()
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert ended.stdout.count("wrote ") == 1 and "blurred.1006.exr" in ended.stdout, ended.stdout
    assert shot.finished() == list(FRAMES)
    assert all(shot.output(frame).stat().st_mtime_ns == time for frame, time in before.items())

    # Another setting is another picture.
    ended = shot.run(Options="--focus-distance 2 --f-number f/2 --quality draft")
    assert ended.stdout.count("wrote ") == 12, ended.stdout


def test_paths_of_another_host_are_mapped(shot: Shot) -> None:
    rules = [
        {
            "source_path_format": "POSIX",
            "source_path": "/show/sh010",
            "destination_path": str(shot.folder),
        }
    ]
    mapping = json.dumps({"version": "pathmapping-1.0", "path_mapping_rules": rules})
    ended = shot.run(
        "--path-mapping-rules",
        mapping,
        Lens="/show/sh010/lens.json",
        PlateFolder="/show/sh010/plates",
        OutputFolder="/show/sh010/out",
        Frames="1001-1002",
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert shot.finished() == [1001, 1002]


def test_depth_passes_in_other_files_and_names_with_spaces(shot: Shot) -> None:
    folder = shot.folder / "depth passes"
    (shot.folder / "plates").rename(folder)
    plain = shot.run(Frames="1001", PlateFolder=str(folder))
    assert plain.returncode == 0, plain.stdout + plain.stderr
    ended = shot.run(
        Frames="1001",
        PlateFolder=str(folder),
        DepthFolder=str(folder),
        DepthName="plate.%04d.exr:Z",
        OutputName="its $HOME.%04d.exr",
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert (shot.folder / "out" / "its $HOME.1001.exr").is_file()


def test_library_lens_and_files_of_their_own(shot: Shot) -> None:
    """Paths with spaces are mapped, and quotes hold words of the options together."""
    side = shot.folder / "side files"
    side.mkdir()
    (side / "rack.csv").write_text("frame,focus-distance\n1001,2\n1002,4\n")
    shutil.copy(shot.folder / "plates" / "plate.1001.exr", side / "clean 1.exr")
    shutil.copy(CONFIG, side / "show 1.ocio")
    rules = [{"source_path_format": "POSIX", "source_path": "/show", "destination_path": str(shot.folder)}]
    ended = shot.run(
        "--path-mapping-rules",
        json.dumps({"version": "pathmapping-1.0", "path_mapping_rules": rules}),
        Lens="library:modern-50",
        Frames="1001-1002",
        AnimationTable="/show/side files/rack.csv",
        CleanPlate="/show/side files/clean 1.exr",
        OcioConfig="/show/side files/show 1.ocio",
        Options=f"--quality draft --in-space ACEScg --working-space 'Linear ARRI Wide Gamut 4' --depth '{side}/clean 1.exr:Z'",
    )
    log = ended.stdout + ended.stderr
    assert ended.returncode == 0, log
    assert shot.finished() == [1001, 1002], log
    info = subprocess.run([shot.seidel, "info", shot.output(1002)], capture_output=True, text=True, check=True).stdout
    for setting in ["library:modern-50", "focus-distance: 4 m", "on, background", "working-space: Linear ARRI Wide Gamut 4"]:
        assert setting in info, info


def test_a_table_beside_the_plates_sets_the_focus(shot: Shot) -> None:
    rows = "".join(f"Frame {frame} Metadata\ndistance: {frame}mm\n\n" for frame in FRAMES)
    (shot.folder / "plates" / "take.txt").write_text(rows)
    ended = shot.run(LensMetadata="take.txt", Frames="1001-1002", Options="--quality draft")
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "focus 1.001 m from `distance` of take.txt (1.001 to 1.002 m over 2 frames)" in ended.stdout, ended.stdout
