"""Live streams: they need an end, and a connection that breaks off is taken up again or told of."""

import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
import pytest

import epibar
from epibar import EpibarError
from epibar.cli import main
from epibar.sources import colour_frames
from epibar.sources.colour_frames import ColourFrames
from epibar.sources.frame_range import FrameRange

SIZE = (64, 48)
RATE = 50


def jpeg(index):
    frame = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
    cv2.rectangle(frame, (index % 48, 10), (index % 48 + 12, 34), (250, 250, 250), -1)
    return cv2.imencode(".jpg", frame)[1].tobytes()


@pytest.fixture
def camera():
    """A camera on this machine that goes on for ever, or breaks off after so many frames."""

    class Handler(BaseHTTPRequestHandler):
        breaks = None
        opened = 0
        most = 1 << 30

        def do_GET(self):
            kind = type(self)
            kind.opened += 1
            if kind.opened > kind.most:
                self.send_error(503)
                return
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            for index in range(kind.breaks or 100_000):
                data = jpeg(index)
                try:
                    self.wfile.write(b"--frame\r\nContent-Type: image/jpeg\r\n")
                    self.wfile.write(b"Content-Length: %d\r\n\r\n%b\r\n" % (len(data), data))
                except OSError:
                    return
                time.sleep(1 / RATE)

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://admin:hunter2@127.0.0.1:{server.server_port}/video.mjpg", Handler
    server.shutdown()
    server.server_close()
    thread.join()


def test_a_stream_needs_an_end(camera, tmp_path, capsys):
    with pytest.raises(EpibarError, match="a live stream has no end") as error:
        epibar.record(camera[0])
    assert "hunter2" not in str(error.value)
    assert main(["record", camera[0], "--out", str(tmp_path / "x.npz")]) == 2
    told = capsys.readouterr().err
    assert "--seconds 60" in told
    assert "hunter2" not in told


@pytest.mark.parametrize("part", [{"frames": (0, 30)}, {"frames": (5, 20)}, {"seconds": 0.8}])
def test_a_stream_with_an_end_is_recorded(part, camera, monkeypatch):
    monkeypatch.setattr(colour_frames, "LIVE_PRIMING", 0.5)
    recording = epibar.record(camera[0], lines=50, **part)
    if "frames" in part:
        assert recording.frames == part["frames"][1] - part["frames"][0]
    else:
        assert recording.frames > 5
        assert recording.times[-1] < 0.8
    assert recording.name == "video"
    assert "hunter2" not in "".join(recording.warnings)


def test_a_stream_that_breaks_off_is_taken_up_again(camera, monkeypatch):
    address, handler = camera
    handler.breaks = 20
    monkeypatch.setattr(colour_frames, "RECONNECT_AFTER", (0.4, 0.4))
    with ColourFrames(address, frames=FrameRange(0, 50)) as frames:
        times = [moment for _, moment, _ in frames]
    assert len(times) == 50
    assert np.all(np.diff(times) > 0)
    # Time went on where nothing came.
    assert np.sum(np.diff(times) > 0.4) == handler.opened - 1 >= 1
    assert any("broke off" in text for text in frames.warnings)
    assert any("gaps" in text for text in frames.warnings)


def test_a_stream_that_is_gone_is_told_of(camera, monkeypatch):
    address, handler = camera
    handler.breaks, handler.most = 20, 1
    monkeypatch.setattr(colour_frames, "RECONNECT_AFTER", (0.1, 0.1))
    with ColourFrames(address, frames=FrameRange(0, 50)) as frames:
        count = sum(1 for _ in frames)
    assert 0 < count <= 20
    assert any("ended after" in text for text in frames.warnings)
    assert "hunter2" not in "".join(frames.warnings)


def test_seconds_of_a_file(tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / "v.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10, SIZE)
    for index in range(40):
        writer.write(cv2.imdecode(np.frombuffer(jpeg(index), np.uint8), cv2.IMREAD_COLOR))
    writer.release()
    with ColourFrames(tmp_path / "v.avi", frames=FrameRange(10, None, 1.5)) as frames:
        assert frames.frame_count == 15
        assert [index for index, _, _ in frames] == list(range(15))
    masks = np.zeros((40, 8, 8), bool)
    np.savez(tmp_path / "m.npz", masks=masks, fps=10.0)
    assert epibar.record(tmp_path / "m.npz", masks=True, lines=10, seconds=1.5).frames == 15
    for wrong in (0, -1, float("nan"), float("inf"), "x"):
        with pytest.raises(EpibarError, match="seconds"):
            epibar.record(tmp_path / "v.avi", seconds=wrong)
