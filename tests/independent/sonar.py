"""What sequence.json says of the sonar and of the labelled objects, as the checks see it: with sequence.py
the only place that spells its key names."""
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

import physics
import pulses
from beam_patterns import Shading
from pulses import Pulse
from surface_laws import Law


@dataclass(frozen=True)
class Instance:
    """One labelled object, point target or volume."""

    identity: int
    name: str
    class_name: str
    class_id: int
    kind: str
    law: Law | None
    vertex_reflectivity: bool
    coherent: dict | None
    target_strength_db: float | None
    volume_strength_db: float | None
    box: dict | None = None
    parts: tuple = ()

    @property
    def surfaces(self):
        """Law and coherent part of the object, then of its parts that have their own."""
        return ((self.law, self.coherent), *self.parts)


@dataclass(frozen=True)
class Grid:
    """Size, scale and place of a Cartesian image: upper left corner ahead and to port."""

    height: int
    width: int
    metres_per_pixel: float
    x_top_m: float
    y_left_m: float


@dataclass(frozen=True)
class Detector:
    """The levels of images, by the words of sequence.json."""

    looks: int
    floor_db: float | None
    noise_db: float
    integrate: float
    law: str


@dataclass(frozen=True)
class Adc:
    """The converter: bits, level of full scale, and the step that the file states."""

    bits: int
    full_scale_db: float
    step_pa: float


@dataclass
class Sonar:
    """What the formulas need of a sequence's sonar, SI units."""

    beams: int
    spacing_rad: float
    width_rad: float
    elevation_width_rad: float
    fan_rad: float
    rays_elevation: int
    rays_azimuth: int
    frequency_hz: float
    bandwidth_hz: float
    source_pressure_pa_m: float
    range_min_m: float
    range_max_m: float
    sound_speed_m_s: float
    absorption_db_m: float
    pulse: Pulse
    normalization: str
    noise_level_db: float | None
    shading: Shading = Shading()
    elevation_shading: Shading = Shading()
    transmit_width_rad: float | None = None
    adc: Adc | None = None
    detector: Detector | None = None
    snr_db: float | None = None
    tolerance: float = 1e-5
    stated_noise_pa2: float | None = None
    unequal_azimuths_rad: tuple = ()
    unequal_widths_rad: tuple = ()
    unsupported: list = field(default_factory=list)

    @cached_property
    def samples(self):
        return physics.stored_samples(self.bandwidth_hz, self.range_max_m, self.sound_speed_m_s)

    @cached_property
    def spectrum(self):
        extent_s = pulses.extent_s(self.pulse, self.bandwidth_hz, self.frequency_hz)
        bins = pulses.transform_length(self.samples, self.bandwidth_hz, extent_s)
        return pulses.spectrum(self.pulse, bins, self.bandwidth_hz, self.frequency_hz)

    @cached_property
    def azimuths_rad(self):
        if self.unequal_azimuths_rad:
            return np.array(self.unequal_azimuths_rad)
        return physics.beam_azimuths_rad(self.beams, self.spacing_rad)

    @cached_property
    def borders_rad(self):
        if self.unequal_azimuths_rad:
            return physics.beam_borders_rad(self.azimuths_rad)
        return (np.arange(self.beams + 1) - self.beams / 2.0) * self.spacing_rad

    @cached_property
    def weights(self):
        widths_rad = np.array(self.unequal_widths_rad) if self.unequal_widths_rad else self.width_rad
        middles_rad = (self.borders_rad[1:] + self.borders_rad[:-1]) / 2.0 if self.unequal_azimuths_rad else None
        return physics.mixing_weights(
            self.azimuths_rad, widths_rad, self.normalization, self.shading, middles_rad
        )

    def sector_position(self, azimuth_rad):
        """k at the lower border of sector k, linear within a sector."""
        if not self.unequal_azimuths_rad:
            return azimuth_rad / self.spacing_rad + self.beams / 2.0
        borders, azimuth_rad = self.borders_rad, np.asarray(azimuth_rad, np.float64)
        place = np.interp(azimuth_rad, borders, np.arange(self.beams + 1.0))
        return place + np.minimum(azimuth_rad - borders[0], 0) + np.maximum(azimuth_rad - borders[-1], 0)

    def beam_position(self, azimuth_rad):
        """j at the azimuth of beam j, linear between beams."""
        if not self.unequal_azimuths_rad:
            return azimuth_rad / self.spacing_rad + (self.beams - 1) / 2.0
        return np.interp(azimuth_rad, self.azimuths_rad, np.arange(float(self.beams)))

    def sector_width_rad(self, beam):
        return np.diff(self.borders_rad)[beam] if self.unequal_azimuths_rad else self.spacing_rad

    @property
    def range_step_m(self):
        return self.sound_speed_m_s / (2.0 * self.bandwidth_hz)

    @property
    def noise_power_pa2(self):
        """The noise by its own formula; what the file states where it hangs on the first ping."""
        if self.noise_level_db is None:
            return self.stated_noise_pa2
        return physics.noise_power_pa2(
            self.noise_level_db, self.bandwidth_hz, self.pulse.processing_gain(self.bandwidth_hz)
        )


def _optional_fields(kind, entry, names):
    """A record from those of its fields that the file gives."""
    return kind(**{field_name: entry[key] for key, field_name in names.items() if key in entry})


def _rows(entry, names):
    """Lists of lists as tuples, so that records can be compared."""
    return {**entry, names: tuple(map(tuple, entry[names]))} if names in entry else entry


def _shading(entry):
    return _optional_fields(
        Shading, entry, {name: name for name in ("kind", "side_lobe_db", "nbar")}
    )


def sonar_from_json(info):
    """The sonar of a sequence.json, with what the closed formulas cannot cover named."""
    sonar, water, rays = info["sonar"], info["water"], info["sonar"]["rays"]
    beams, noise, adc = sonar["beams"], info.get("noise") or {}, sonar.get("adc")
    unsupported = ["volumes"] if any(i["kind"] == "volume" for i in info["instances"]) else []
    unsupported += ["an array of elements"] if "receiver" in info["sonar"] else []
    pulse = dict(_rows(sonar["pulse"], "rows"), window=sonar.get("window", "none"))
    return Sonar(
        beams=beams["count"],
        spacing_rad=beams["spacing_rad"],
        unequal_azimuths_rad=tuple(beams.get("azimuth_rad", ())),
        unequal_widths_rad=tuple(beams.get("widths_rad", ())),
        width_rad=beams["width_rad"],
        elevation_width_rad=sonar["elevation"]["width_rad"],
        fan_rad=sonar["elevation"]["fan_rad"],
        rays_elevation=rays["elevation"],
        rays_azimuth=rays["azimuth"],
        frequency_hz=sonar["frequency_hz"],
        bandwidth_hz=sonar["bandwidth_hz"],
        source_pressure_pa_m=physics.source_pressure_pa_m(sonar["source_level_db"]),
        range_min_m=sonar["range_min_m"],
        range_max_m=sonar["range_max_m"],
        sound_speed_m_s=water["sound_speed_m_s"],
        absorption_db_m=water["absorption_db_m"],
        pulse=_optional_fields(
            Pulse,
            pulse,
            {name: name for name in ("shape", "duration_s", "taper", "rows", "window")},
        ),
        normalization=sonar["normalization"],
        noise_level_db=noise.get("spectrum_level_db"),
        shading=_shading(beams["shading"]),
        elevation_shading=_shading(sonar["elevation"]["shading"]),
        transmit_width_rad=beams["transmit_width_rad"],
        adc=None if adc is None else Adc(adc["bits"], adc["full_scale_db"], adc["step_pa"]),
        detector=Detector(**sonar["detector"]) if "detector" in sonar else None,
        snr_db=noise.get("snr_db"),
        tolerance=info["synthesis"]["tolerance"],
        stated_noise_pa2=noise.get("power_pa2"),
        unsupported=unsupported,
    )


def _law(entry):
    """The law of a surface or of one of its parts; a member that Law does not know is an error."""
    return Law(**_rows(entry["law"], "rows"))


def instance_from_json(entry):
    """One entry of the list of instances."""
    law = _law(entry) if entry["kind"] == "surface" else None
    return Instance(
        entry["id"],
        entry["name"],
        entry["class"],
        entry["class_id"],
        entry["kind"],
        law,
        entry.get("vertex_reflectivity", False) or entry.get("image_reflectivity", False),
        entry.get("coherent"),
        entry.get("target_strength_db"),
        entry.get("strength_db"),
        box=entry.get("box"),
        parts=tuple((_law(part), part["coherent"]) for part in entry.get("parts", [])),
    )
