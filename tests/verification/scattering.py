"""Scattering laws on a flat seabed, where each range has its own grazing angle; colored meshes."""
import math

import numpy as np

import beam_patterns
import measure
import physics
from bench import Row, case, diffuse
from closed_forms import Envelope, azimuth_integral
from levels import BEAM_RAD
from pulses import Pulse
from surface_laws import Law, backscatter_strength, echo_energy, rough_strength

HEIGHT_M, FAN_DEG, WIDTH_DEG = 3.0, 170.0, 60.0
BEAMS, SPACING_DEG = 13, 0.5
ENVELOPE = Envelope(Pulse())
GRAZING_DEG = (75, 60, 45, 30, 20, 11)
HALF_WINDOW_DEG = 1.5
TABLE_ROWS = tuple(
    zip(range(0, 91, 10), (-60.0, -38.0, -32.0, -29.0, -26.0, -25.0, -22.0, -20.5, -17.0, -12.0))
)
SAND_FILE = "grazing_deg,strength_db\n" + "".join(f"{g},{s}\n" for g, s in TABLE_ROWS)

# So weak that the edge of the fan, from which the specular part echoes, does not matter.
ROUGH = {"reflection": 0.05, "roughness_rms_m": 4e-4, "roughness_correlation_m": 2e-3}
WAVELENGTH_M = 1500.0 / 9e5

# Name, material, exponent of the scenario, the law here.
LAWS = [
    ("lambert_1", {"reflectivity": 1e-3}, None, Law("lambert", 1e-3, 1.0)),
    ("lambert_2", {"reflectivity": 1e-3}, 2, Law("lambert", 1e-3, 2.0)),
    (
        "lambert_0.5",
        {"reflectivity": 1e-3, "law": {"lambert": {"exponent": 0.5}}},
        3,
        Law("lambert", 1e-3, 0.5),
    ),
    (
        "lommel_seeliger",
        {"reflectivity": 1e-3, "law": "lommel_seeliger"},
        2,
        Law("lommel_seeliger", 1e-3),
    ),
    ("rough", {"reflectivity": 1e-3, "coherent": {"model": "kirchhoff", **ROUGH}}, None, Law("lambert", 1e-3, 1.0)),
    ("table", {"law": {"table": {"file": "sand.csv"}}}, 2, Law("table", rows=TABLE_ROWS)),
]


def seabed_run(bench, material, exponent):
    """Clean power on the middle beam of a sonar that looks along a flat seabed below it."""
    sequence = bench.run(
        {
            "sonar": {
                "range_max_m": 20,
                "beams": {"count": BEAMS, "spacing_deg": SPACING_DEG},
                "elevation": {"width_deg": WIDTH_DEG, "fan_deg": FAN_DEG},
                "rays": {"elevation": 2500},
            },
            "scattering": {"lambert_exponent": exponent} if exponent else {},
            "materials": {"m": material},
            "objects": [diffuse("floor", {"plane": {}}, (0, 0, -HEIGHT_M))],
        },
        scatterers=True,
        files={"sand.csv": SAND_FILE} if "sand.csv" in str(material) else None,
    )
    sonar = sequence.sonar
    return sonar, physics.expected_power(sequence.scatterers(0), sonar)[BEAMS // 2]


def strength_of(name, law, sine):
    """s_b of the law, and for `rough` what its roughness scatters."""
    strength = backscatter_strength(law, sine)
    return strength + rough_strength(ROUGH, WAVELENGTH_M, sine) if name == "rough" else strength


def seabed_power(name, law, sonar, samples):
    """S0^2 int B_az^2 dtheta int s_b B_el^2 r^-3 |s|^2 dr; dS = r dr dtheta on a plane below."""
    width, half = math.radians(WIDTH_DEG), math.radians(BEAMS * SPACING_DEG / 2)
    offset = np.arange(-40, 40, 1 / 32)
    r = (np.asarray(samples)[:, None] + offset) * sonar.range_step_m
    seen = r > HEIGHT_M / math.sin(math.radians(FAN_DEG / 2))
    r = np.where(seen, r, HEIGHT_M)
    sine = HEIGHT_M / r
    density = (
        seen
        * strength_of(name, law, sine)
        * r**-3
        * beam_patterns.beam_pattern(np.arcsin(sine), width) ** 2
    )
    heard = ENVELOPE.power_at(-offset / sonar.bandwidth_hz)
    along = (density @ heard) * sonar.range_step_m / 32
    return sonar.source_pressure_pa_m**2 * azimuth_integral(BEAM_RAD, -half, half) * along


@case("law")
def laws(bench):
    """Expected level of the seabed at several grazing angles, mean over 3 degrees of each."""
    for name, material, exponent, law in LAWS:
        sonar, clean = seabed_run(bench, material, exponent)
        got_db, wanted_db = [], []
        for grazing in GRAZING_DEG:
            near, far = (
                HEIGHT_M / math.sin(math.radians(grazing + s * HALF_WINDOW_DEG)) for s in (1, -1)
            )
            samples = np.arange(
                math.ceil(near / sonar.range_step_m), math.floor(far / sonar.range_step_m) + 1
            )
            wanted = seabed_power(name, law, sonar, samples).mean()
            got = clean[samples].mean()
            strength = 10 * math.log10(strength_of(name, law, math.sin(math.radians(grazing))))
            wanted_db.append(strength)
            got_db.append(strength + 10 * math.log10(got / wanted))
            yield Row(f"law.{name}.{grazing}", f"{name}: expected level of a flat seabed at grazing {grazing} deg",
                      float(measure.level(wanted)), float(measure.level(got)), 0.1)
        bench.curve("laws", name, GRAZING_DEG, got_db)
        dense = np.linspace(2.0, 90.0, 200)
        bench.curve(
            "laws",
            name,
            dense,
            None,
            10 * np.log10(strength_of(name, law, np.sin(np.radians(dense)))),
        )


def colored_quad(kind, left, right):
    """A square of 2 m at x = 0, grey from one side (y = -1) to the other, as PLY or OBJ."""
    corners = [(0, -1, -1, left), (0, 1, -1, right), (0, 1, 1, right), (0, -1, 1, left)]
    if kind == "obj":
        lines = [
            f"v {x} {y} {z} {g / 255:.9f} {g / 255:.9f} {g / 255:.9f}" for x, y, z, g in corners
        ]
        return "\n".join(lines + ["f 1 2 3", "f 1 3 4"]) + "\n"
    head = [
        "ply",
        "format ascii 1.0",
        "element vertex 4",
        "property float x",
        "property float y",
        "property float z",
        "property uchar red",
        "property uchar green",
        "property uchar blue",
        "element face 2",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    lines = [f"{x} {y} {z} {g} {g} {g}" for x, y, z, g in corners]
    return "\n".join(head + lines + ["3 0 1 2", "3 0 2 3"]) + "\n"


@case("color")
def colored_mesh(bench):
    """Vertex colors multiply the reflectivity, straight between the vertices."""
    for kind, left, right in (("ply", 0, 255), ("ply", 64, 64), ("obj", 51, 204)):
        name = f"mesh.{kind}"
        sequence = bench.run(
            {
                "sonar": {"beams": {"count": 24, "spacing_deg": 1}, "rays": {"elevation": 30}},
                "materials": {"m": {"reflectivity": 1e-3}},
                "objects": [
                    diffuse(
                        "quad", {"mesh": {"file": name, "reflectivity": "vertex_color"}}, (3, 0, 0)
                    )
                ],
            },
            scatterers=True,
            files={name: colored_quad(kind, left, right)},
        )
        sonar, echo = sequence.sonar, sequence.scatterers(0)
        step = sonar.fan_rad / sonar.rays_elevation
        solid_angle = (
            sonar.spacing_rad * 2 * np.cos(echo["elevation_rad"].astype(float)) * math.sin(step / 2)
        )
        range_m = echo["delay_s"] * sonar.sound_speed_m_s / 2
        grey = (left + (right - left) * (echo["y"] + 1) / 2) / 255
        wanted = grey * echo_energy(
            Law("lambert", 1e-3, 1.0),
            echo["cos_incidence"].astype(float),
            range_m**2 * solid_angle,
        )
        gap = np.abs(echo["variance"] - wanted).max() / wanted.max()
        yield Row(
            f"color.{kind}.{left}",
            f"{kind} with grey {left} to {right} of 255: largest gap of an echo's energy, {len(echo)} echoes",
            0.0,
            float(gap),
            1e-3,
            "of the largest",
        )
        yield Row(
            f"color.{kind}.{left}.mean", f"{kind} with grey {left} to {right}: energy of all echoes over the expected",
            1.0, float(echo["variance"].sum(dtype=float) / wanted.sum()), 1e-3, ""
        )
