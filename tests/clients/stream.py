#!/usr/bin/env python3
"""Drives grbl-streamer, a sender of its own make, as its users do: connect, read the settings, home, stream a program,
hold it in the middle and resume it.

    stream.py PORT PROGRAM X,Y,Z RESULT.json

It fails unless the machine stands still in the hold and goes on from there, every line of the program is accepted and the
machine stands at X,Y,Z mm at the end. What it sent is written to RESULT.json, for the machine's side to be held against.
"""

import json
import os
import sys
import threading
import time

import grbl_streamer
from grbl_streamer.interface import Interface

PATIENCE_S = 30
POLL_S = 0.02
RESET = "\x18"


class Wire(Interface):
    """grbl-streamer's serial port, its bytes and lines counted, in the order in which its threads write them."""

    turn = threading.Lock()
    bytes_sent = 0
    lines_sent = 0
    heard = b""

    def write(self, data):
        with Wire.turn:
            Wire.bytes_sent += len(data)
            Wire.lines_sent = 0 if data == RESET else Wire.lines_sent + data.count("\n")
            return super().write(data)

    def _handle_data(self, data):
        Wire.heard += data
        super()._handle_data(data)

    @staticmethod
    def is_answered():
        """Every line sent since the reset has its `ok`, behind the welcome."""
        return Wire.heard.rpartition(b"Grbl ")[2].count(b"ok\r\n") == Wire.lines_sent


grbl_streamer.Interface = Wire


class OneAtATime(grbl_streamer.GrblStreamer):
    """grbl-streamer 2.0.2 lets two threads choose the next line: the one that starts a job, and the one that hears its
    first `ok`. Now and then it so sends a line twice and leaves out another. Here they take turns.

    It also asks `$G` by itself when the machine becomes idle, and takes that `ok` for a line's of a job begun meanwhile:
    so it goes beyond Grbl's 128 bytes. `is_quiet` tells when that is over."""

    def __init__(self, callback):
        self.turn = threading.Lock()
        super().__init__(callback)

    def is_quiet(self):
        """The machine is idle, and nothing is asked of it, nor to be."""
        to_ask = self.gcode_parser_state_requested or self.hash_state_requested
        return self._last_cmode == "Idle" and not to_ask and Wire.is_answered()

    def _stream(self):
        with self.turn:
            super()._stream()


class Sender:
    """grbl-streamer, and what it tells."""

    def __init__(self, port):
        self.settings = {}
        self.errors = []
        self.alarms = []
        self.accepted = 0
        self.booted = threading.Event()
        self.completed = threading.Event()
        self.grbl = OneAtATime(self.tell)
        self.grbl.poll_interval = POLL_S
        self.grbl.cnect(port)

    def tell(self, event, *data):
        if event == "on_boot":
            self.booted.set()
        elif event == "on_read" and data[0].startswith("$"):
            number, value = data[0][1:].split("=")
            self.settings[int(number)] = value
        elif event == "on_error":
            self.errors.append(f"{data[0]} to {data[1]}")
        elif event == "on_alarm":
            self.alarms.append(data[0])
        elif event == "on_processed_command":
            self.accepted += 1
        elif event == "on_job_completed":
            self.completed.set()

    def wait(self, what, condition):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if self.alarms:
                sys.exit(f"the machine is in alarm, waiting for {what}: {self.alarms}")
            if time.monotonic() > end:
                sys.exit(f"no {what} within {PATIENCE_S} s; the machine is {self.grbl.cmode} at {self.grbl.cmpos}")
            time.sleep(POLL_S)


def main(port, program, place, result):
    sender = Sender(port)
    grbl = sender.grbl
    sender.wait("welcome after the reset", sender.booted.is_set)
    grbl.poll_start()
    sender.wait("settings", lambda: 132 in sender.settings)
    print(f"connected; {len(sender.settings)} settings read, {sender.settings[100]} steps/mm in X")

    sender.wait("status Idle", lambda: grbl.cmode == "Idle")
    grbl.homing()
    sender.wait("status Home", lambda: grbl.cmode == "Home")
    sender.wait("end of homing", lambda: grbl.cmode == "Idle")
    if grbl.cmpos != (0, 0, 0):
        sys.exit(f"homed, and yet at {grbl.cmpos}")
    print("homed")

    if sender.errors:
        sys.exit(f"refused while connecting: {sender.errors}")
    sender.wait("answers to what it asks by itself", grbl.is_quiet)
    grbl.job_new()
    grbl.load_file(program)
    sender.completed.clear()
    grbl.job_run()
    sender.wait("status Run away from the origin", lambda: grbl.cmode == "Run" and grbl.cmpos[0] > 10)
    grbl.hold()
    sender.wait("status Hold:0", lambda: grbl.cmode == "Hold:0")
    held = grbl.cmpos
    time.sleep(10 * POLL_S)
    if (grbl.cmode, grbl.cmpos) != ("Hold:0", held):
        sys.exit(f"held at {held}, and yet {grbl.cmode} at {grbl.cmpos}")
    print(f"held at {held}")
    grbl.resume()
    sender.wait("status Run away from the hold", lambda: grbl.cmode == "Run" and grbl.cmpos != held)
    sender.wait("end of the program", lambda: sender.completed.is_set() or sender.errors)
    if sender.errors or sender.accepted != grbl.buffer_size:
        sys.exit(f"{sender.accepted} of {grbl.buffer_size} lines accepted; {sender.errors}")
    wanted = tuple(float(mm) for mm in place.split(","))
    sender.wait(f"Idle at {wanted}", lambda: grbl.cmode == "Idle" and grbl.cmpos == wanted)
    print(f"{sender.accepted} lines of {program} accepted; Idle at {grbl.cmpos}")

    grbl.poll_stop()
    with open(result, "w") as out:
        json.dump({"lines": sender.accepted, "bytes_sent": Wire.bytes_sent}, out)
    grbl.disconnect()


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    # A failure must not wait for grbl-streamer's threads.
    threading.excepthook = lambda failed: (sys.__excepthook__(*failed[:3]), os._exit(1))
    try:
        main(*sys.argv[1:])
    except SystemExit as failed:
        print(failed, file=sys.stderr, flush=True)
        os._exit(1)
