"""Runs single instructions on Unicorn's Cortex-M33 and writes each case and its result as a line of JSON, for m33-compare.mjs.

    python m33-cases.py --elf FIRMWARE --count N --seed N

Half of the instructions are those of the firmware, each encoding as likely as any other; the others have random bits. Registers and
flags are random, and memory is as `content` below says. What Unicorn takes for undefined or for a fault is left out.
"""
import argparse
import json
import random
import struct

from unicorn import UC_ARCH_ARM, UC_HOOK_MEM_WRITE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_R0, UC_ARM_REG_SP, UC_ARM_REG_XPSR, UC_CPU_ARM_CORTEX_M33

RAM = 0x20000000
CODE = 0x10000000
CASE_BYTES, CODE_BYTES = 0x20, 0x1000000
NOWHERE = 0xffffffff
# What does not come to its end within this time has gone elsewhere.
PATIENCE_US = 100_000
REGISTERS = [UC_ARM_REG_R0 + number for number in range(13)] + [UC_ARM_REG_SP, UC_ARM_REG_LR]
# Addresses into two pages in the middle of RAM, from which offsets reach no farther than it does.
BASE, SPREAD, REACH = RAM + 0x20000, 0x800, 0x40000


def content(address):
    """The byte of memory at an address, before anything is written."""
    return ((address * 2654435761) >> 13) & 0xff


MEMORY = bytes(content(RAM + offset) for offset in range(REACH))


def is_ram(address):
    return RAM <= address < RAM + REACH


def is_code(name):
    return name.startswith('$t')


def instructions(path):
    """The encodings of a firmware's code, by the mapping symbols of its ELF file."""
    file = open(path, 'rb').read()
    at, size, count, names_in = struct.unpack_from('<I', file, 32)[0], *struct.unpack_from('<HHH', file, 46)
    sections = [struct.unpack_from('<10I', file, at + size * index) for index in range(count)]
    found = set()
    for section in sections:
        if section[1] != 2:
            continue
        names = file[sections[section[6]][4]:][:sections[section[6]][5]]
        marks = []
        for offset in range(section[4], section[4] + section[5], 16):
            name, value, _, _, _, index = struct.unpack_from('<IIIBBH', file, offset)
            text = names[name:names.index(b'\0', name)].decode()
            if text[:2] in ('$t', '$d') and index < count:
                marks.append((index, value & ~1, text))
        marks.sort()
        for (index, begin, text), following in zip(marks, marks[1:] + [(None, None, '')]):
            if not is_code(text):
                continue
            base, start, length = sections[index][3], sections[index][4], sections[index][5]
            end = following[1] if following[0] == index else base + length
            code = file[start + begin - base:start + end - base]
            offset = 0
            while offset + 2 <= len(code):
                first = struct.unpack_from('<H', code, offset)[0]
                if first < 0xe800:
                    found.add((first,))
                elif offset + 4 <= len(code):
                    found.add((first, struct.unpack_from('<H', code, offset + 2)[0]))
                offset += 2 if first < 0xe800 else 4
    return sorted(found)


def leaves_the_core(op):
    """Hints, calls of the system, masks of interrupts, special registers, coprocessors and floats: they are no arithmetic."""
    first = op[0]
    if len(op) == 1:
        return first & 0xff00 in (0xbe00, 0xbf00, 0xdf00, 0xde00) or first & 0xffe8 == 0xb660
    return first & 0xec00 == 0xec00 and first & 0xef00 != 0xea00 and (first >> 9) & 7 in (6, 7) or first & 0xff80 == 0xf380 and op[1] & 0xd000 == 0x8000


def is_unpredictable(op):
    """A stack pointer that is no multiple of 4, lists of registers that have it or, to store, PC, comparisons of PC, and addresses that
    are written back into a register that is loaded or stored."""
    first = op[0]
    if len(op) == 1:
        return first & 0xfd87 == 0x4485 or first & 0xff00 == 0x4500 and (first & 0x87 == 0x87 or first & 0x78 == 0x78)
    base, target, other = first & 15, op[1] >> 12, op[1] >> 8 & 15
    if first & 0xfe00 == 0xf800 and not first & 0x80 and op[1] & 0x900 == 0x900:
        return base == target
    if first & 0xfe60 == 0xe860:
        return base in (target, other)
    return first & 0xfe40 == 0xe800 and op[1] & (0x2000 if first & 0x10 else 0xa000) != 0


def branches(op):
    first = op[0]
    if len(op) == 1:
        return (first >> 12 == 0xd or first >> 11 == 0x1c or first & 0xf500 == 0xb100 or first & 0xff00 in (0x4700, 0xbd00)
                or first & 0xfd87 in (0x4487, 0x4485) and first & 0xff87 in (0x4487, 0x4687))
    return first >> 11 == 0x1e and op[1] & 0x8000 != 0 or first & 0xfe50 == 0xe810 and op[1] & 0x8000 != 0 or first & 0xfff0 == 0xe8d0 and op[1] & 0xe0 == 0 \
        or first & 0xfe70 == 0xf850 and op[1] >> 12 == 15


class Oracle:
    def __init__(self):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M33)
        self.uc.mem_map(RAM, REACH)
        self.uc.mem_map(CODE, CODE_BYTES)
        self.uc.mem_write(RAM, MEMORY)
        self.writes = {}
        self.at = CODE
        self.uc.hook_add(UC_HOOK_MEM_WRITE, self.wrote)

    def wrote(self, _, __, address, size, value, ___):
        for index in range(size):
            self.writes[address + index] = (value >> (8 * index)) & 0xff

    def run(self, code, end, branches, registers, flags):
        """The registers, flags and bytes written; nothing if Unicorn refuses the instruction."""
        # Each case has a place of its own, because Unicorn keeps what it has translated.
        self.at += CASE_BYTES
        self.uc.mem_write(self.at, b''.join(struct.pack('<H', half) for half in code))
        for register, value in zip(REGISTERS, registers):
            self.uc.reg_write(register, value)
        self.uc.reg_write(UC_ARM_REG_XPSR, flags | 1 << 24)
        self.writes = {}
        try:
            # An end is quicker than a count, but a branch does not come to it.
            self.uc.emu_start(self.at | 1, NOWHERE if branches else self.at + end, timeout=PATIENCE_US, count=int(branches))
        except UcError:
            return None
        finally:
            for address in filter(is_ram, self.writes):
                self.uc.mem_write(address, bytes([content(address)]))
        if not all(map(is_ram, self.writes)):
            return None
        after = [self.uc.reg_read(register) for register in REGISTERS] + [self.uc.reg_read(UC_ARM_REG_PC)]
        if not branches and after[-1] != self.at + end:
            return None
        return after, self.uc.reg_read(UC_ARM_REG_XPSR) & 0xf8000000, sorted(self.writes.items())


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument('--elf', required=True)
    options.add_argument('--count', type=int, default=1000)
    options.add_argument('--seed', type=int, default=1)
    given = options.parse_args()
    rng, oracle = random.Random(given.seed), Oracle()
    known = [op for op in instructions(given.elf) if not leaves_the_core(op)]
    values = (lambda: rng.getrandbits(32), lambda: rng.randrange(256), lambda: BASE + 4 * rng.randrange(SPREAD // 4),
              lambda: BASE + 4 * rng.randrange(SPREAD // 4), lambda: rng.choice((0, 1, 0x80000000, 0xffffffff, 0x7fffffff)))
    done = 0
    while done < given.count:
        if oracle.at + 2 * CASE_BYTES > CODE + CODE_BYTES:
            oracle = Oracle()
        is_known = rng.random() < 0.5
        if is_known:
            op = rng.choice(known)
        else:
            first = rng.getrandbits(16)
            op = (first,) if first < 0xe800 else (first, rng.getrandbits(16))
        # Branches take Unicorn a hundred times as long.
        if leaves_the_core(op) or is_unpredictable(op) or branches(op) and rng.random() > 0.03:
            continue
        registers = [rng.choice(values)() for _ in range(13)] + [BASE + 8 * rng.randrange(SPREAD // 8), rng.getrandbits(32)]
        flags = rng.getrandbits(5) << 27
        # Some stand in a block of one, behind IT with a random condition.
        block = (0xbf08 | rng.randrange(14) << 4,) if rng.random() < 0.2 and not branches(op) else ()
        code = (block + op + (0xbf00,) * 8)[:8]
        result = oracle.run(code, 2 * len(block + op), branches(op), registers, flags)
        if result is None:
            continue
        after, after_flags, writes = result
        print(json.dumps({'at': oracle.at, 'code': code, 'isFirmware': is_known, 'steps': 1 + len(block), 'registers': registers, 'flags': flags, 'after': after, 'afterFlags': after_flags, 'writes': writes}))
        done += 1


main()
