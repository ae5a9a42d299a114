"""A source of all basic types and their sequences, for trying data ports."""

from __future__ import annotations

from rtkit import component as rt


class SeqOut(rt.Component):
    """Write a count as every basic data type, alone and as a sequence."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    boolean = rt.OutPort(rt.TimedBoolean, name="Boolean")
    char = rt.OutPort(rt.TimedChar, name="Char")
    octet = rt.OutPort(rt.TimedOctet, name="Octet")
    short = rt.OutPort(rt.TimedShort, name="Short")
    long = rt.OutPort(rt.TimedLong, name="Long")
    float = rt.OutPort(rt.TimedFloat, name="Float")
    double = rt.OutPort(rt.TimedDouble, name="Double")
    string = rt.OutPort(rt.TimedString, name="String")
    boolean_seq = rt.OutPort(rt.TimedBooleanSeq, name="BooleanSeq")
    char_seq = rt.OutPort(rt.TimedCharSeq, name="CharSeq")
    octet_seq = rt.OutPort(rt.TimedOctetSeq, name="OctetSeq")
    short_seq = rt.OutPort(rt.TimedShortSeq, name="ShortSeq")
    long_seq = rt.OutPort(rt.TimedLongSeq, name="LongSeq")
    float_seq = rt.OutPort(rt.TimedFloatSeq, name="FloatSeq")
    double_seq = rt.OutPort(rt.TimedDoubleSeq, name="DoubleSeq")
    string_seq = rt.OutPort(rt.TimedStringSeq, name="StringSeq")

    length = rt.Parameter(10, doc="Number of items in each sequence")

    def on_activated(self, context: str) -> None:
        """Count from zero."""
        self._count = 0

    def on_execute(self, context: str) -> None:
        """Write the count, and a sequence that begins with it."""
        now = rt.Time.now()
        first = self._count
        numbers = [(first + step) % 128 for step in range(self.length)]
        self._count = (first + 1) % 128
        self.boolean.write(rt.TimedBoolean(now, first % 2 == 1))
        self.char.write(rt.TimedChar(now, chr(first)))
        self.octet.write(rt.TimedOctet(now, first))
        self.short.write(rt.TimedShort(now, first))
        self.long.write(rt.TimedLong(now, first))
        self.float.write(rt.TimedFloat(now, first / 2))
        self.double.write(rt.TimedDouble(now, first / 10))
        self.string.write(rt.TimedString(now, str(first)))
        self.boolean_seq.write(rt.TimedBooleanSeq(now, tuple(n % 2 == 1 for n in numbers)))
        self.char_seq.write(rt.TimedCharSeq(now, tuple(chr(n) for n in numbers)))
        self.octet_seq.write(rt.TimedOctetSeq(now, bytes(numbers)))
        self.short_seq.write(rt.TimedShortSeq(now, tuple(numbers)))
        self.long_seq.write(rt.TimedLongSeq(now, tuple(numbers)))
        self.float_seq.write(rt.TimedFloatSeq(now, tuple(n / 2 for n in numbers)))
        self.double_seq.write(rt.TimedDoubleSeq(now, tuple(n / 10 for n in numbers)))
        self.string_seq.write(rt.TimedStringSeq(now, tuple(str(n) for n in numbers)))


def SeqOutInit(manager: rt.Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(SeqOut)
