#!/usr/bin/env python3
"""A DURAPULSE GS20 as a slave of pymodbus, which knows nothing of Isostep: the registers of run, frequency and status.

    vfd.py PORT

Its output has the frequency that was set at once, and only while it runs. It serves until it is killed.
"""

import sys

from pymodbus.server import StartSerialServer
from pymodbus.simulator import DataType, SimData, SimDevice

RUN, STATUS = 0x2000, 0x2100
READ, WORDS = 3, DataType.REGISTERS
FORWARD, REVERSE, STOP = 0x12, 0x22, 0x01
written = {RUN: STOP, RUN + 1: 0}


async def act(function, start, address, count, registers, values):
    """Keeps what is written, and shows in the status what comes of it."""
    for offset, value in enumerate(values or []):
        written[address + offset] = value
    if function == READ and address == STATUS:
        runs = written[RUN] in (FORWARD, REVERSE)
        set_frequency = written[RUN + 1]
        status = [0, 0, set_frequency, set_frequency if runs else 0, 150 if runs else 0]
        registers[STATUS - start : STATUS - start + len(status)] = status


StartSerialServer(
    SimDevice(1, simdata=[SimData(RUN, values=[STOP, 0], datatype=WORDS), SimData(STATUS, values=[0] * 5, datatype=WORDS)], action=act),
    port=sys.argv[1],
    baudrate=9600,
)
