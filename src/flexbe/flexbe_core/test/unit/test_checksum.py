"""The checksum of the wire protocol."""

from flexbe_core.engine.supervision import checksum


def test_known_sums():
    # Adler-32 as in RFC 1950, computed by hand: a = 1 + 97, b = a; (b << 16) + a.
    assert checksum("a") == (98 << 16) + 98
    assert checksum("") == 1


def test_a_sum_fits_a_signed_32_bit_integer():
    assert 0 <= checksum("\u00e4" * 100_000) < 1 << 31
