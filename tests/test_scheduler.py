"""All pairs on a real Dask cluster: a scheduler and two worker processes, one of which is killed."""

import importlib.util
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import epibar
from epibar import EpibarError, synthetic
from epibar.jobs import dask_executor
from epibar.jobs.inputs import CameraInput

pytestmark = [
    pytest.mark.skipif(
        importlib.util.find_spec("distributed") is None,
        reason="Dask is not installed: pip install 'epibar[dask]'",
    ),
    pytest.mark.skipif(os.name == "nt", reason="signals differ on Windows"),
]

CAMERAS = 5
FAST = {"masks": True, "lines": 4000, "method": "lines", "report": False}
WORDS = ["--masks", "--lines", "4000", "--method", "lines", "--no-report"]
PATIENCE = 120


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    scene = synthetic.cubes(3, cameras=CAMERAS, objects=12, frames=200, size=(160, 120), size_m=(0.25, 0.45))
    folder = tmp_path_factory.mktemp("masks")
    for index in range(CAMERAS):
        np.savez_compressed(folder / f"cam{index + 1}.npz", masks=scene.masks(index), fps=25.0)
    return [str(folder / f"cam{index + 1}.npz") for index in range(CAMERAS)]


class Cluster:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder, protocol="tcp", options=()):
        self.folder = folder
        self.processes = []
        self.options = options
        words = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--protocol", protocol]
        self._start("scheduler", *words, *options)
        self.address = self._wait_for("scheduler", "Scheduler at:").split()[-1]
        self.workers = [self.start_worker(name) for name in ("first", "second")]

    def start_worker(self, name, *words, environment=None):
        options = ["--no-nanny", "--nthreads", "1", "--name", name, "--no-dashboard", *self.options, *words]
        worker = self._start("worker", self.address, *options, log=name, environment=environment)
        self._wait_for(name, "Registered to:")
        return worker

    def _start(self, kind, *words, log=None, environment=None):
        command = [sys.executable, "-m", "dask", kind, *words]
        # Workers look for this module, whose functions they are given.
        paths = {"PYTHONPATH": str(Path(__file__).parent)}
        environment = {**os.environ, **paths, **(environment or {})}
        with open(self.folder / f"{log or kind}.log", "wb") as stream:
            process = subprocess.Popen(
                command, stdout=stream, stderr=stream, cwd=self.folder, env=environment
            )
        self.processes.append(process)
        return process

    def _wait_for(self, log, text):
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            for line in self.log(log).splitlines():
                if text in line:
                    return line
            time.sleep(0.05)
        raise AssertionError(f"the {log} did not start:\n{self.log(log)}")

    def log(self, name):
        return (self.folder / f"{name}.log").read_text()

    def close(self):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    folder = tmp_path / "cluster"
    folder.mkdir()
    cluster = Cluster.__new__(Cluster)
    cluster.processes = []
    try:
        cluster.__init__(folder)
        yield cluster
    finally:
        cluster.close()


def calibrate(masks, out, scheduler):
    words = ["calibrate", *masks, "--out", str(out), *WORDS, "--scheduler", scheduler]
    return subprocess.Popen(
        [sys.executable, "-m", "epibar", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def wait_for_pairs(process, out, count):
    """Wait until so many pairs are kept."""
    deadline = time.monotonic() + PATIENCE
    while len(list((Path(out) / "pairs").glob("[!.]*.npz"))) < count:
        assert time.monotonic() < deadline
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def test_a_killed_worker_costs_a_retry(masks, cluster, tmp_path):
    process = calibrate(masks, tmp_path / "dask", cluster.address)
    wait_for_pairs(process, tmp_path / "dask", 2)
    # Stopped first, so that what it was given cannot be done by it before it dies.
    cluster.workers[0].send_signal(signal.SIGSTOP)
    time.sleep(0.3)
    assert process.poll() is None, "finished before the worker could be killed: give it more to do"
    cluster.workers[0].kill()
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "Traceback" not in err, err
    assert len(out.splitlines()) == CAMERAS * (CAMERAS - 1) // 2
    assert "Remove worker" in cluster.log("scheduler")

    epibar.calibrate_all(masks, tmp_path / "threads", **FAST)
    written = (tmp_path / "dask" / "calibration.json").read_bytes()
    assert written == (tmp_path / "threads" / "calibration.json").read_bytes()
    assert sum(pair["accepted"] for pair in json.loads(written)["pairs"]) >= 3


def test_a_lost_scheduler_ends_the_run_and_keeps_what_is_done(masks, cluster, tmp_path):
    process = calibrate(masks, tmp_path / "out", cluster.address)
    wait_for_pairs(process, tmp_path / "out", 1)
    cluster.processes[0].kill()
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2, err
    assert "goes on from there" in err
    assert "Traceback" not in err, err
    kept = len(list((tmp_path / "out" / "pairs").glob("[!.]*.npz")))
    assert len(json.loads((tmp_path / "out" / "calibration.json").read_text())["pairs"]) == kept


def where(camera):
    """Runs on a worker: its address."""
    from distributed import get_worker

    return get_worker().address


def test_a_camera_is_recorded_where_its_video_is(masks, cluster, tmp_path):
    cluster.start_worker("third", "--host", "127.0.0.2")
    camera = CameraInput("cam1", masks[0], 0)
    with dask_executor(cluster.address) as executor:
        anywhere = {executor.submit(where, camera).result(PATIENCE) for _ in range(12)}
        assert len({address.rpartition(":")[0] for address in anywhere}) == 2
        # The three share their disks: that the third alone has the video must be made up.
        seen = executor._seen(masks[0])
        assert seen.keys() == {"127.0.0.1", "127.0.0.2"}
        seen["127.0.0.1"] = None
        there = {executor.submit(where, camera).result(PATIENCE) for _ in range(12)}
        assert {address.rpartition(":")[0] for address in there} == {"tcp://127.0.0.2"}
        missing = executor.submit(where, CameraInput("cam9", str(tmp_path / "nowhere.mp4"), 0))
        with pytest.raises(EpibarError, match=r"nowhere.mp4: no Dask worker can read it"):
            missing.result(PATIENCE)


def test_workers_with_another_epibar(cluster, tmp_path):
    (tmp_path / "epibar").mkdir()
    (tmp_path / "epibar" / "__init__.py").write_text("")
    cluster.start_worker("third", environment={"PYTHONPATH": str(tmp_path)})
    with pytest.raises(EpibarError, match="cannot import epibar"), dask_executor(cluster.address):
        pass


def test_a_scheduler_without_workers(cluster):
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    with pytest.raises(EpibarError, match="no worker after 1 s"), dask_executor(cluster.address, 1.0):
        pass


@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes certificates with openssl")
def test_tls_with_certificates_and_without(tmp_path):
    files = {"ca-file": tmp_path / "cert.pem", "cert": tmp_path / "cert.pem", "key": tmp_path / "key.pem"}
    words = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=epibar"]
    words += ["-addext", "subjectAltName=IP:127.0.0.1", "-keyout", files["key"], "-out", files["cert"]]
    subprocess.run(words, check=True, capture_output=True)
    options = [word for name, path in files.items() for word in (f"--tls-{name}", str(path))]
    import dask

    (tmp_path / "cluster").mkdir()
    cluster = Cluster(tmp_path / "cluster", "tls", options)
    try:
        assert cluster.address.startswith("tls://")
        with (
            pytest.raises(EpibarError, match="no certificates; name them in Dask's settings"),
            dask_executor(cluster.address, 5.0),
        ):
            pass
        # Left to the garbage collector, it may be closed while the next one starts, which waits for ever.
        assert not [thread for thread in threading.enumerate() if thread.name == "IO loop"]
        settings = {
            "distributed.comm.tls.ca-file": str(files["ca-file"]),
            "distributed.comm.tls.client.cert": str(files["cert"]),
            "distributed.comm.tls.client.key": str(files["key"]),
        }
        # That whole runs go through an executor is tested without TLS.
        with dask.config.set(settings), dask_executor(cluster.address) as executor:
            assert executor.submit(sum, (1, 2)).result(timeout=60) == 3
    finally:
        cluster.close()


def test_nobody_answers():
    started = time.monotonic()
    with (
        pytest.raises(EpibarError, match=r"tcp://127.0.0.1:9: no answer within 1 s"),
        dask_executor("tcp://127.0.0.1:9", 1.0),
    ):
        pass
    assert time.monotonic() - started < 20


def test_something_else_answers():
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer():
            connection, _ = server.accept()
            with connection:
                connection.sendall(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n" * 20)
                time.sleep(3)

        threading.Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with (
            pytest.raises(EpibarError, match="is 'dask scheduler' running there"),
            dask_executor(address, 2.0),
        ):
            pass


def test_local_workers(masks, tmp_path):
    process = calibrate(masks[:2], tmp_path / "out", "local")
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "Traceback" not in err, err
    assert len(json.loads((tmp_path / "out" / "calibration.json").read_text())["pairs"]) == 1
