#!/usr/bin/env python3
"""Drives grbl-streamer, a sender of its own make, as its users do: connect, read the settings, home, and stream
programs, with changes of tools, and each held in the middle and resumed.

    stream.py PORT PROGRAMS X,Y,Z RESULT.json

Of the folder PROGRAMS these are two_tools.nc, parking.nc, engraving.nc with a laser ($32=1) and square.nc with a
spindle at S500 ($32=0). two_tools.nc is streamed twice: M6 waits in Hold, with lengths from the table of tools
($341=0), and then in Tool, where a plate below measures the first tool and the Z of the second is set by hand
($341=1). It fails unless the machine stands still in each hold and goes on from there; a laser is off while held and
on again after it, a spindle keeps turning; every line is accepted, and the machine stands where two_tools.nc ends,
with the length of its last tool, and at X,Y,Z mm at the end of each other program, all off. What it sent is written to
RESULT.json, for the machine's side to be held against.
"""

import json
import os
import re
import sys
import threading
import time
from pathlib import Path

import grbl_streamer
from grbl_streamer.interface import Interface

PATIENCE_S = 30
POLL_S = 0.02
RESET = "\x18"
# So many at least in a hold: at rest every tenth tells what is on, and one more when that changes.
REPORTS_IN_HOLD = 12
SPINDLE_S = 500
# The tool has been put in, and the sender knows of the state Tool: what it sends from here on is by hand.
TOOL_ACKNOWLEDGED = b"\xa3"
TWO_TOOLS = "two_tools.nc"
# The lengths that its tools have in the table, and where it ends without them, mm.
LENGTHS_MM = {1: 10.0, 2: 4.0}
TWO_TOOLS_END_MM = (20.0, 20.0, 25.0)


class Report:
    """What a status report tells of spindle or laser: grbl-streamer passes none of that on."""

    def __init__(self, line):
        self.line = line
        self.state = line[1:].partition("|")[0]
        self.s = int(re.search(r"\|FS:[^,]+,(\d+)", line)[1])
        on = re.search(r"\|Ov:[^|>]+(?:\|A:([SCFM]+))?", line)
        # Letter S is M3's, C is M4's. None where the report does not tell.
        self.is_on = on and bool(re.search("[SC]", on[1] or ""))


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

    def write_real_time(self, byte):
        with Wire.turn:
            Wire.bytes_sent += len(byte)
            self.serialport.write(byte)

    def _handle_data(self, data):
        Wire.heard += data
        super()._handle_data(data)

    @staticmethod
    def reports(begin):
        """The status reports that came after the first `begin` bytes."""
        lines = Wire.heard[begin:].decode("ascii").split("\r\n")[:-1]
        return [Report(line) for line in lines if line.startswith("<") and line.endswith(">")]


grbl_streamer.Interface = Wire


class OneAtATime(grbl_streamer.GrblStreamer):
    """grbl-streamer 2.0.2 lets two threads choose the next line: the one that starts a job, and the one that hears its
    first `ok`. Now and then it so sends a line twice and leaves out another. Here they take turns.

    It also asks `$G` by itself when the machine becomes idle, and takes that `ok` for a line's of a job begun meanwhile:
    so it goes beyond Grbl's 128 bytes. `is_quiet` tells when that is over.

    It leaves out words that Grbl does not have, and says nothing: M6, T and canned cycles are added here to those that it
    sends. And it knows nothing of lines that are sent by hand while a program waits, and would take their `ok` for the
    program's."""

    def __init__(self, callback):
        self.turn = threading.Lock()
        self.unanswered_by_hand = 0
        self.answers = 0
        super().__init__(callback)
        known = self.preprocessor.whitelist_commands
        known["G"] += [81, 83, 98]
        known["M"] += [6]
        known["T"] = list(LENGTHS_MM)

    def send_by_hand(self, line):
        self.unanswered_by_hand += 1
        self._iface_write(line + "\n")

    def acknowledge_tool(self):
        self._iface.write_real_time(TOOL_ACKNOWLEDGED)

    def _handle_ok(self):
        if self.unanswered_by_hand:
            self.unanswered_by_hand -= 1
        else:
            super()._handle_ok()
        self.answers += 1

    def _on_bootup(self):
        self.answers = 0
        super()._on_bootup()

    def is_answered(self):
        """Every line sent since the reset has its `ok`, and no `ok` is still to be taken for a line's of the next job."""
        return self.answers == Wire.lines_sent

    def is_quiet(self):
        """The machine is idle, and nothing is asked of it, nor to be."""
        to_ask = self.gcode_parser_state_requested or self.hash_state_requested
        return self._last_cmode == "Idle" and not to_ask and self.is_answered()

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

    def connect(self):
        self.wait("welcome after the reset", self.booted.is_set)
        self.grbl.poll_start()
        self.wait("settings", lambda: 132 in self.settings)
        print(f"connected; {len(self.settings)} settings read, {self.settings[100]} steps/mm in X")
        self.wait("status Idle", lambda: self.grbl.cmode == "Idle")

    def home(self):
        grbl = self.grbl
        grbl.homing()
        self.wait("status Home", lambda: grbl.cmode == "Home")
        self.wait("end of homing", lambda: grbl.cmode == "Idle")
        if grbl.cmpos != (0, 0, 0):
            sys.exit(f"homed, and yet at {grbl.cmpos}")
        print("homed")

    def type(self, line):
        """Sends a line while no program runs."""
        self.wait("answers to what it asks by itself", self.grbl.is_quiet)
        self.grbl.send_immediately(line)
        self.wait(f"answer to {line}", self.grbl.is_answered)

    def set(self, number, value):
        """Gives the machine a setting, and reads it back."""
        self.type(f"${number}={value}")
        del self.settings[number]
        self.grbl.request_settings()
        self.wait("settings", lambda: number in self.settings and self.grbl.is_answered())
        if self.errors or self.settings[number] != value:
            sys.exit(f"${number} was to be {value} and is {self.settings[number]}; {self.errors}")

    def begin(self, program):
        if self.errors:
            sys.exit(f"refused before the program: {self.errors}")
        grbl = self.grbl
        self.wait("answers to what it asks by itself", grbl.is_quiet)
        grbl.job_new()
        grbl.write(program)
        self.completed.clear()
        self.accepted = 0
        grbl.job_run()

    def hold(self, is_there):
        """Holds the machine once it runs and its last report is as `is_there` says: it must stand still. Returns its
        reports from there."""
        grbl = self.grbl
        begin = len(Wire.heard)
        last = lambda: Wire.reports(begin)[-1:]
        self.wait("status Run, to be held", lambda: grbl.cmode == "Run" and any(map(is_there, last())))
        begin = len(Wire.heard)
        grbl.hold()
        self.wait("status Hold:0", lambda: grbl.cmode == "Hold:0")
        place = grbl.cmpos
        held = lambda: [report for report in Wire.reports(begin) if report.state == "Hold:0"]
        self.wait("reports in the hold", lambda: len(held()) >= REPORTS_IN_HOLD and tells_what_is_on(held()))
        if (grbl.cmode, grbl.cmpos) != ("Hold:0", place):
            sys.exit(f"held at {place}, and yet {grbl.cmode} at {grbl.cmpos}")
        return held()

    def resume(self, is_as_before):
        """Resumes the held machine: it must go on, and tell what `is_as_before` looks for."""
        grbl, place, begin = self.grbl, self.grbl.cmpos, len(Wire.heard)
        grbl.resume()
        self.wait("status Run away from the hold", lambda: grbl.cmode == "Run" and grbl.cmpos != place)
        self.wait("spindle or laser as before the hold", lambda: is_as_before(Wire.reports(begin)))

    def wait_to_change(self, tool, state, begin):
        """Waits until M6 waits for this tool in this state, all off. The bytes before `begin` are of earlier changes."""
        prompt = b"[MSG:M6: put in tool %d," % tool
        self.wait(f"prompt for tool {tool}", lambda: prompt in Wire.heard[begin:])
        self.wait(f"status {state}", lambda: self.grbl.cmode == state)
        begin = len(Wire.heard)
        self.wait("report of what is on", lambda: tells_what_is_on(Wire.reports(begin)))
        check_tool(f"in the wait for tool {tool}", Wire.reports(begin), 0)

    def by_hand(self, line):
        """Sends a line while M6 waits, and returns what is heard until it is answered."""
        begin = len(Wire.heard)
        self.grbl.send_by_hand(line)
        self.wait(f"answer to {line}", lambda: self.grbl.unanswered_by_hand == 0 or self.errors)
        if self.errors:
            sys.exit(f"{line} by hand: {self.errors}")
        return Wire.heard[begin:].decode("ascii")

    def jog_by_hand(self, line):
        """Jogs while M6 waits, and waits until that has ended."""
        place = self.grbl.cmpos
        self.by_hand(line)
        self.wait("status Tool, elsewhere", lambda: self.grbl.cmode == "Tool" and self.grbl.cmpos != place)

    def check_lengths(self, tool, length_mm):
        """This tool must be in the spindle, and this length be in force."""
        # Reports tell it when it changes.
        self.wait(f"report of tool {tool}", lambda: re.findall(rb"\|T:(\d+)", Wire.heard)[-1:] == [b"%d" % tool])
        self.wait("answers to what it asks by itself", self.grbl.is_quiet)
        begin = len(Wire.heard)
        self.grbl.hash_state_requested = True
        self.wait("tool length", lambda: b"[TLO:" in Wire.heard[begin:] and self.grbl.is_quiet())
        if self.grbl.settings_hash["TLO"] != (length_mm,):
            sys.exit(f"tool {tool} has length {length_mm}, and yet {self.grbl.settings_hash['TLO']} is in force")

    def end(self, name, place):
        """Waits for the end of the program: every line must be accepted, and the machine rest at the place, all off."""
        grbl = self.grbl
        self.wait("end of the program", lambda: self.completed.is_set() or self.errors)
        if self.errors or self.accepted != grbl.buffer_size:
            sys.exit(f"{self.accepted} of {grbl.buffer_size} lines of {name} accepted; {self.errors}")
        self.wait(f"Idle at {place}", lambda: grbl.cmode == "Idle" and grbl.cmpos == place)
        begin = len(Wire.heard)
        self.wait("report of what is on", lambda: tells_what_is_on(Wire.reports(begin)))
        check_tool(f"after {name}", Wire.reports(begin), 0)
        print(f"{self.accepted} lines of {name} accepted; Idle at {grbl.cmpos}")


def tells_what_is_on(reports):
    return any(report.is_on is not None for report in reports)


def is_on(reports):
    """They tell of a spindle or laser that is on, and of its S."""
    return any(report.is_on for report in reports) and reports[-1].s > 0


def check_tool(when, reports, s):
    """All of them tell this S, and that spindle or laser is on if that is above 0; some must tell the latter."""
    wrong = [report.line for report in reports if report.s != s or report.is_on not in (None, s > 0)]
    if wrong or not tells_what_is_on(reports):
        sys.exit(f"S{s} {when}, and yet {wrong or [report.line for report in reports]}")


def two_tools_in_hold(sender, programs, _):
    sender.set(341, "0")
    for tool, length_mm in LENGTHS_MM.items():
        sender.type(f"G10 L1 P{tool} Z{length_mm}")
    begin = len(Wire.heard)
    sender.begin((programs / TWO_TOOLS).read_text())
    for tool in LENGTHS_MM:
        sender.wait_to_change(tool, "Hold:0", begin)
        print(f"tool {tool} put in at {sender.grbl.cmpos}")
        sender.resume(lambda _: True)
    x, y, z = TWO_TOOLS_END_MM
    sender.end(TWO_TOOLS, (x, y, z + LENGTHS_MM[2]))
    sender.check_lengths(2, LENGTHS_MM[2])


def two_tools_by_hand(sender, programs, _):
    sender.set(341, "1")
    begin = len(Wire.heard)
    sender.begin((programs / TWO_TOOLS).read_text())

    sender.wait_to_change(1, "Tool", begin)
    sender.grbl.acknowledge_tool()
    sender.jog_by_hand("$J=G53 Z30 F2400")
    measured = sender.by_hand("$TPW")
    in_force = sender.by_hand("$#")
    if "[PRB:0.000,0.000,10.000:1]" not in measured or "[TLO:0.000]" not in in_force or "[T:1|" in in_force:
        sys.exit(f"the first tool counts as of length 0, and yet {measured}{in_force}")
    print("tool 1 measured at the plate")
    sender.resume(lambda _: True)

    sender.wait_to_change(2, "Tool", begin)
    sender.grbl.acknowledge_tool()
    sender.jog_by_hand("$J=G91 X5 Z-70 F2400")
    sender.by_hand("G10 L20 P0 Z8.5")
    print("tool 2: Z set by hand")
    sender.resume(lambda _: True)
    # It was set 70 mm below the end of the travel: work zero of a tool without a length is there.
    zero_mm = float(sender.settings[132]) - 70 - 8.5
    x, y, z = TWO_TOOLS_END_MM
    sender.end(TWO_TOOLS, (x, y, z - 20 + zero_mm + LENGTHS_MM[2]))
    sender.check_lengths(2, LENGTHS_MM[2])
    if b"|TLR:1" not in Wire.heard[begin:]:
        sys.exit("the first tool was measured, and yet no report says that there is a reference")
    # The other programs begin without all that.
    sender.type("G10 L2 P1 X0 Y0 Z0")
    sender.type("G49")


def park(sender, programs, place):
    sender.begin((programs / "parking.nc").read_text())
    held = sender.hold(lambda _: sender.grbl.cmpos[0] > 10)
    check_tool("held with nothing on", held, 0)
    print(f"held at {sender.grbl.cmpos}")
    sender.resume(lambda _: True)
    sender.end("parking.nc", place)


def engrave(sender, programs, place):
    sender.set(32, "1")
    sender.begin((programs / "engraving.nc").read_text())
    held = sender.hold(lambda report: report.s > 0)
    check_tool("held with a laser", held, 0)
    print(f"held at {sender.grbl.cmpos}, its laser off")
    sender.resume(is_on)
    sender.end("engraving.nc", place)


def mill(sender, programs, place):
    sender.set(32, "0")
    sender.begin(f"M3 S{SPINDLE_S}\n{(programs / 'square.nc').read_text()}\nM5\n")
    held = sender.hold(lambda report: report.s == SPINDLE_S)
    check_tool("held with a spindle", held, SPINDLE_S)
    print(f"held at {sender.grbl.cmpos}, its spindle at S{held[-1].s}")
    sender.resume(is_on)
    sender.end("square.nc", place)


def main(port, programs, place, result):
    programs, place = Path(programs), tuple(float(mm) for mm in place.split(","))
    sender = Sender(port)
    sender.connect()
    sender.home()
    lines = 0
    for job in (two_tools_in_hold, two_tools_by_hand, park, engrave, mill):
        job(sender, programs, place)
        lines += sender.accepted
    sender.grbl.poll_stop()
    with open(result, "w") as out:
        json.dump({"lines": lines, "bytes_sent": Wire.bytes_sent}, out)
    sender.grbl.disconnect()


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
