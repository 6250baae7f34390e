"""Quadratures that the expected values are made of; formulas are those of tests/independent."""
import numpy as np

import beam_patterns
import pulses
from beam_patterns import Shading

BAND_HZ = 29900.0
CARRIER_HZ = 9e5
SOUND_SPEED_M_S = 1500.0
SOURCE_DB = 220.0
# Bins and points for one sample of an envelope that is taken for continuous.
BINS, FINE = 2048, 64


def integral(y, x):
    """Trapezoids on a grid fine enough that more points change nothing that is printed."""
    return float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))


def azimuth_integral(width_rad, low_rad, high_rad, shading=Shading()):
    """int B_az^2 dtheta from low to high, angles off the beam."""
    angle = np.linspace(low_rad, high_rad, 200001)
    return integral(beam_patterns.beam_pattern(angle, width_rad, shading) ** 2, angle)


def elevation_integral(width_rad, low_rad, high_rad):
    """int B_el^2 cos(phi) dphi over the fan."""
    angle = np.linspace(low_rad, high_rad, 20001)
    return integral(beam_patterns.beam_pattern(angle, width_rad) ** 2 * np.cos(angle), angle)


class Envelope:
    """The envelope of a unit echo as a function of time, nearly continuous."""

    def __init__(self, pulse, bandwidth_hz=BAND_HZ, frequency_hz=CARRIER_HZ):
        self.bandwidth_hz = bandwidth_hz
        spectrum = pulses.spectrum(pulse, BINS, bandwidth_hz, frequency_hz)
        around = np.fft.fftshift(pulses.envelope(spectrum, FINE))
        self.power = np.abs(around) ** 2
        self.samples = (np.arange(BINS * FINE) - BINS * FINE // 2) / FINE

    @property
    def energy(self):
        """b int |s|^2 dt."""
        return float(self.power.sum()) / FINE

    def power_at(self, offset_s):
        """|s|^2 at times off the delay."""
        return np.interp(np.asarray(offset_s) * self.bandwidth_hz, self.samples, self.power)


def decibels(ratio):
    return 10.0 * np.log10(ratio)


def sonar_equation_db(range_m, strength_db, absorption_db_m=0.0):
    """SL - 40 log10 r - 2 alpha r + TS."""
    return SOURCE_DB - 40.0 * np.log10(range_m) - 2.0 * absorption_db_m * range_m + strength_db
