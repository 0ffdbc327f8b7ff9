#!/usr/bin/env python3
"""Records checksums of what Seidel computes, and compares two records. README.md says how to use it."""

import argparse
import datetime
import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from array import array
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cases
import fingerprint
import inputs

HERE = Path(__file__).resolve().parent


class Failure(Exception):
    """A command of a case failed."""


class Lazy:
    """A mapping that makes its values when they are first asked for, each once."""

    def __init__(self, make):
        self.make = make
        self.guard = threading.Lock()
        self.values = {}

    def __getitem__(self, name):
        with self.guard:
            lock, _ = self.values.setdefault(name, (threading.RLock(), []))
            held = self.values[name][1]
        with lock:
            if not held:
                held.append(self.make(name))
            return held[0]


class Recorder:
    """Runs cases in a temporary folder."""

    def __init__(self, options, folder):
        self.options = options
        self.folder = folder
        self.made = Lazy(self._make_input)
        self.lens = Lazy(self._find_lens)
        self.outputs = Lazy(self._run)
        self.environment = {name: value for name, value in os.environ.items() if name != "OCIO"}
        self.by_name = {case.name: case for case in cases.every()}
        (folder / "inputs").mkdir()

    def _make_input(self, name):
        return inputs.make(name, self.options.data, self.folder / "inputs")

    def _find_lens(self, name):
        """Returns the profile `name`: the stored one if there is one, else that of this build's fit."""
        if self.options.lenses:
            stored = self.options.lenses / f"{name}.json"
            if stored.exists():
                return stored
        case = "demo" if name == "demo" else f"fit/{name}"
        return self.outputs[case] / "lens.json"

    def _run(self, name):
        """Runs a case; returns the folder with its outputs."""
        out = self.folder / name
        out.mkdir(parents=True)
        options = self.options
        places = {
            "library": options.plugin,
            "plates": options.data / "plates",
            "psf": options.data / "psf",
            "gap": options.data / "gap",
            "out": out,
            "made": self.made,
            "lens": self.lens,
        }
        starts = {
            "c_abi": [sys.executable, str(HERE / "c_abi.py")],
            "ofx": [str(options.ofx_host), str(options.ofx_plugin)],
        }
        for command in self.by_name[name].commands:
            first, *rest = shlex.split(command)
            start = starts.get(first, [str(options.seidel), first])
            words = start + [word.format_map(places) for word in rest]
            self._call(words)
        return out

    def _call(self, words):
        target = subprocess.DEVNULL
        if ">" in words:
            words, (path,) = words[: words.index(">")], words[words.index(">") + 1 :]
            target = open(path, "wb")
        try:
            pipes = {"stdin": subprocess.DEVNULL, "stdout": target, "stderr": subprocess.PIPE}
            done = subprocess.run(words, **pipes, env=self.environment, check=False)
        finally:
            if target is not subprocess.DEVNULL:
                target.close()
        if done.returncode != 0:
            said = done.stderr.decode(errors="replace").strip()
            raise Failure(f"status {done.returncode}: {shlex.join(words)}\n{said}")

    def record(self, case):
        """Runs a case and returns its lines: names and checksums. Prints wall-clock time and CPU time of the commands."""
        start, used = time.monotonic(), cpu_time()
        try:
            out = self.outputs[case.name]
            took = time.monotonic() - start
            lines = [(name, output.sha256()) for name, output in self._read(case.name, out)]
            if not lines:
                raise Failure("the case wrote nothing that is recorded")
        except (Failure, ValueError, OSError) as why:
            took = time.monotonic() - start
            print(f"{case.name}: {why}", file=sys.stderr)
            lines = [(case.name, "failed")]
        cpu = f"{cpu_time() - used:8.1f} s CPU" if self.options.jobs == 1 else ""
        print(f"{took:8.1f} s{cpu}  {case.name}", file=sys.stderr, flush=True)
        if case.name.split("/")[0] != "fit" and case.name != "demo":
            shutil.rmtree(self.folder / case.name, ignore_errors=True)
        return lines

    def _read(self, case, out):
        """Returns the outputs of a case by name, and stores their numbers."""
        groups = {}
        for path in sorted(out.rglob("*")):
            if path.is_file():
                # The tiles of a PSF set count as one output.
                tiles = path.parent.name == "psf" and path.suffix == ".exr"
                place = path.parent / "*.exr" if tiles else path
                groups.setdefault(f"{case}/{place.relative_to(out)}", []).append(path)
        for name, paths in groups.items():
            if any(name.endswith(skipped) for skipped in cases.UNCHECKED):
                continue
            read = [fingerprint.read(path) for path in paths]
            if None in read:
                continue
            output = read[0] if len(read) == 1 else fingerprint.joined(read)
            if self.options.numbers:
                store(self.options.numbers, name, output)
                if case == "demo" or case.startswith("fit/"):
                    self._store_lens(case, paths[0])
            yield name, output

    def _store_lens(self, case, path):
        if path.name == "lens.json":
            folder = self.options.numbers / "lenses"
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, folder / f"{case.removeprefix('fit/')}.json")


def cpu_time():
    """Returns the CPU time of all commands so far, in seconds."""
    times = os.times()
    return times.children_user + times.children_system


def stored_at(folder, name, ending):
    return folder / "values" / (name.replace("*", "all") + ending)


def store(folder, name, output):
    """Stores the numbers or samples of an output in the folder `--numbers`."""
    if output.numbers:
        path = stored_at(folder, name, ".numbers.json")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(output.numbers, indent=0, sort_keys=True))
    if output.samples:
        path = stored_at(folder, name, ".samples")
        path.parent.mkdir(parents=True, exist_ok=True)
        head = {channel: [values.typecode, len(values)] for channel, values in output.samples.items()}
        body = b"".join(values.tobytes() for values in output.samples.values())
        path.write_bytes(zlib.compress(json.dumps(head).encode() + b"\n" + body, 1))


def stored_samples(path):
    """Returns the samples by channel that `store` wrote."""
    head, body = zlib.decompress(path.read_bytes()).split(b"\n", 1)
    samples = {}
    at = 0
    for channel, (letter, count) in json.loads(head).items():
        samples[channel] = array(letter)
        size = count * samples[channel].itemsize
        samples[channel].frombytes(body[at : at + size])
        at += size
    return samples


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        facts = {name.strip(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
        flags = [one for one in facts.get("flags", "").split() if one in ("avx2", "fma", "avx512f")]
        return f"{facts.get('model name', platform.machine())} ({', '.join(flags)})"
    except OSError:
        return platform.processor() or platform.machine()


def chosen(name, options):
    return not options.only or any(part in name for part in options.only)


def run(options):
    selected = [case for case in cases.every() if chosen(case.name, options)]
    if not selected:
        sys.exit(f"--only {' '.join(options.only)}: no case has such a name")
    print(f"# date: {datetime.date.today().isoformat()}")
    print(f"# processor: {processor()}")
    for note in options.note:
        print(f"# {note}")
    start, used = time.monotonic(), cpu_time()
    failed = 0
    with tempfile.TemporaryDirectory(prefix="seidel-checksums-") as folder:
        recorder = Recorder(options, Path(folder))
        with ThreadPoolExecutor(options.jobs) as pool:
            for lines in pool.map(recorder.record, selected):
                for name, digest in lines:
                    failed += digest == "failed"
                    print(f"{digest}  {name}", flush=True)
    print(f"{time.monotonic() - start:8.1f} s{cpu_time() - used:8.1f} s CPU  in all, {failed} failed", file=sys.stderr)
    return 1 if failed else 0


def read_list(path):
    lines = (line.split("  ", 1) for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return {name: digest for digest, name in lines}


def compare(options):
    """Prints what differs between two lists; with two folders of numbers, by how much."""
    before, after = (
        {name: digest for name, digest in read_list(path).items() if chosen(name, options)}
        for path in (options.before, options.after)
    )
    bad = 0
    for name in sorted(before.keys() | after.keys()):
        one, other = before.get(name), after.get(name)
        if one == other:
            continue
        if other is None or one is None:
            print(f"{name}: only in {options.before if other is None else options.after}")
            bad += 1
            continue
        difference = difference_of(options.numbers, name) if options.numbers else None
        if difference is None:
            print(f"{name}: differs")
            bad += 1
        elif difference[0] == 0:
            print(f"{name}: differs: the values are the same, but not windows, types or order")
            bad += 1
        else:
            size, text = difference
            within = size <= options.tolerance
            bad += not within
            print(f"{name}: {'within the tolerance' if within else 'differs'}: {text}")
    same = sum(before.get(name) == digest for name, digest in after.items())
    print(f"{same} of {len(before.keys() | after.keys())} outputs are the same, {bad} differ or are missing")
    return 1 if bad else 0


def difference_of(folders, name):
    """Returns the largest relative difference of an output's stored values, and a sentence on it."""
    numbers = [stored_at(folder, name, ".numbers.json") for folder in folders]
    if all(path.exists() for path in numbers):
        return difference_of_numbers(*(json.loads(path.read_text(encoding="utf-8")) for path in numbers))
    samples = [stored_at(folder, name, ".samples") for folder in folders]
    if all(path.exists() for path in samples):
        return difference_of_samples(*map(stored_samples, samples))
    return None


def difference_of_numbers(one, other):
    odd = sorted(one.keys() ^ other.keys())
    for key in one.keys() & other.keys():
        numeric = [isinstance(value[key], float) for value in (one, other)]
        if not all(numeric) and one[key] != other[key]:
            odd.append(key)
    if odd:
        return float("inf"), f"{len(odd)} entries are missing or of another value, first {odd[0]}"
    worst = (0.0, "")
    for key, value in one.items():
        if isinstance(value, float) and value != other[key]:
            size = abs(value - other[key]) / max(abs(value), abs(other[key]))
            worst = max(worst, (size, f"{key} {value!r} {other[key]!r}"))
    return worst[0], f"relative difference at most {worst[0]:.3g} ({worst[1]})"


def difference_of_samples(one, other):
    """Differences of samples are relative to the largest sample of the channel."""
    if {name: len(values) for name, values in one.items()} != {name: len(values) for name, values in other.items()}:
        return float("inf"), "other channels or another size"
    worst, place, count = 0.0, "", 0
    for channel, values in one.items():
        if values == other[channel]:
            continue
        differences = [abs(a - b) for a, b in zip(values, other[channel])]
        peak = max(map(abs, values)) or 1.0
        count += sum(map(bool, differences))
        if max(differences) / peak >= worst:
            worst, place = max(differences) / peak, channel
    return worst, f"{count} samples, by at most {worst:.3g} of the channel's peak ({place})"


def main():
    if sys.argv[1:2] == ["compare"]:
        parser = argparse.ArgumentParser(prog="record.py compare", description=compare.__doc__)
        parser.add_argument("before", type=Path)
        parser.add_argument("after", type=Path)
        parser.add_argument("--numbers", type=Path, nargs=2, metavar="DIR", help="the folders of numbers of both")
        parser.add_argument("--tolerance", type=float, default=0.0, help="relative difference that counts as none")
        parser.add_argument("--only", action="append", default=[], metavar="NAME", help="names that contain NAME")
        return compare(parser.parse_args(sys.argv[2:]))
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seidel", type=Path, required=True, help="the command")
    parser.add_argument("--plugin", type=Path, required=True, help="the library with the C ABI")
    parser.add_argument("--ofx-host", type=Path, required=True, help="the test host")
    parser.add_argument("--ofx-plugin", type=Path, required=True, help="the OpenFX plugin: library or bundle")
    parser.add_argument("--data", type=Path, required=True, help="the folder with plates, psf and gap")
    parser.add_argument("--lenses", type=Path, help="stored profiles to use in place of those fitted by this build")
    parser.add_argument("--numbers", type=Path, help="folder to store numbers, samples and profiles in")
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help="cases whose name contains NAME")
    parser.add_argument("--jobs", type=int, default=1, help="cases to run at once")
    parser.add_argument("--note", action="append", default=[], help="a line for the head of the list")
    options = parser.parse_args()
    for name in ("seidel", "plugin", "ofx_host", "ofx_plugin", "data"):
        path = getattr(options, name)
        if not path.exists():
            parser.error(f"--{name.replace('_', '-')} {path}: does not exist")
        setattr(options, name, path.resolve())
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
