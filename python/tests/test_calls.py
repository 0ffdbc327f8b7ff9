"""Progress, cancellation, Ctrl-C, threads and processes."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import LENS

import seidel


@pytest.fixture(scope="module")
def large():
    """An image whose blur by the exact renderer takes far longer than any test waits."""
    random = np.random.default_rng(7)
    return random.random((540, 960, 3), np.float32)


EXACT = seidel.Settings(quality="exact")


def test_progress_rises_to_one(lens, image, depth):
    shares = []
    plain = seidel.apply(lens, image, depth)
    result = seidel.apply(lens, image, depth, progress=shares.append)
    assert shares[0] == 0.0 and shares[-1] == 1.0 and shares == sorted(shares)
    assert np.array_equal(result, plain)


def test_fits_report_progress_and_stop(observations):
    shares = []
    fitted = seidel.Lens.fit(observations, model="moments", progress=shares.append)
    assert shares[0] == 0.0 and shares[-1] == 1.0 and shares == sorted(shares)
    assert fitted == seidel.Lens.fit(observations, model="moments")
    with pytest.raises(seidel.Cancelled):
        seidel.Lens.fit(observations, model="reduced", progress=lambda share: False)


def test_the_callback_stops_the_call(lens, large):
    start = time.monotonic()
    with pytest.raises(seidel.Cancelled) as caught:
        seidel.apply(lens, large, 4.0, settings=EXACT, progress=lambda share: share == 0.0)
    assert time.monotonic() - start < 5.0
    assert caught.value.kind == "cancelled"


@pytest.mark.parametrize("function", ["apply", "remove", "relens"])
def test_exceptions_of_the_callback_pass_through(lens, large, function):
    class Stop(Exception):
        pass

    def progress(share):
        raise Stop("enough")

    lenses = [lens, lens] if function == "relens" else [lens]
    with pytest.raises(Stop, match="enough"):
        getattr(seidel, function)(*lenses, large, 4.0, settings=EXACT, progress=progress)


def test_other_threads_run_meanwhile(lens, image, depth):
    counts, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counts[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.monotonic()
    while time.monotonic() - start < 0.5:
        seidel.apply(lens, image, depth)
    done.set()
    counter.join()
    assert counts[0] > 50


def test_calls_of_several_threads(lens, image, depth):
    expected = seidel.apply(lens, image, depth)
    results = [None] * 4

    def work(k):
        settings = seidel.Settings(threads=k % 3)
        results[k] = seidel.apply(lens, image, depth, settings=settings)

    workers = [threading.Thread(target=work, args=(k,)) for k in range(len(results))]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert all(np.array_equal(result, expected) for result in results)


def test_a_callback_may_call_the_package(lens, image):
    inner = []

    def progress(share):
        if share == 1.0:
            inner.append(seidel.apply(lens, image, 3.0))

    outer = seidel.apply(lens, image, 3.0, progress=progress)
    assert np.array_equal(inner[0], outer)


SLOW_CALL = """
    import signal
    import numpy as np, seidel
    # Jobs in the background of a shell begin with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    lens = seidel.Lens.load({lens!r})
    image = np.random.default_rng(1).random((540, 960, 3), np.float32)
    print("ready", flush=True)
    try:
        seidel.apply(lens, image, 4.0, settings=seidel.Settings(quality="exact"))
    except KeyboardInterrupt:
        print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of other processes are those of POSIX")
def test_ctrl_c_stops_the_call():
    code = textwrap.dedent(SLOW_CALL).format(lens=str(LENS))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=30)
        assert rest == "interrupted\n"
        assert time.monotonic() - start < 5.0
    finally:
        process.kill()


def _blur(arguments):
    profile, image = arguments
    return seidel.apply(seidel.Lens.from_json(profile), image, 3.0)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes(lens, image, method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system starts no processes by {method}")
    # So that the parent has threads that a forked child lacks.
    expected = seidel.apply(lens, image, 3.0)
    with multiprocessing.get_context(method).Pool(1) as pool:
        result = pool.apply_async(_blur, [(lens.to_json(), image)]).get(60)
    assert np.array_equal(result, expected)
