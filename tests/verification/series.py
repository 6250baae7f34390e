"""The fast sum against the direct one over the exported scatterers."""
import numpy as np

import physics
from bench import Row, case, diffuse, point_target

# Tenths under this share of the record's norm are not judged.
WEAK_TENTH = 1e-6
SCENE = {
    "sonar": {
        "range_max_m": 20,
        "beams": {"count": 48, "spacing_deg": 1},
        "rays": {"elevation": 60, "azimuth": 2},
    },
    "materials": {"m": {"reflectivity": 1e-3}},
    "objects": [
        diffuse("floor", {"plane": {}}, (0, 0, -1.2)),
        diffuse("ball", {"sphere": {"radius_m": 0.3}}, (6, 1, -0.3)),
    ],
    # 40 dB above everything else, where leaking sums would drown the weak tenths.
    "point_targets": [point_target("strong", 20.0, (1.5, 0, 0))],
}


@case("V8")
def direct_sum(bench):
    """Relative L2 over the record, and in each tenth against its own norm."""
    for backend in ("cpu", "reference"):
        sequence = bench.run(SCENE, scatterers=True, arguments=("--backend", backend))
        series = sequence.series(0).astype(complex)
        wanted = physics.beam_series(sequence.scatterers(0), sequence.sonar)
        size = np.linalg.norm(wanted)
        tenths = [
            (got, want)
            for got, want in zip(
                np.array_split(series, 10, axis=1), np.array_split(wanted, 10, axis=1)
            )
            if np.linalg.norm(want) > WEAK_TENTH * size
        ]
        worst = max(physics.relative_l2(got, want) for got, want in tenths)
        yield Row(
            f"V8.{backend}.record", f"backend {backend} against the direct sum, a strong echo at 1.5 m: relative L2",
            0.0, float(physics.relative_l2(series, wanted)), 1e-5, ""
        )
        yield Row(f"V8.{backend}.tenth", f"backend {backend}: the worst of {len(tenths)} tenths of the record",
                  0.0, float(worst), 1e-4, "")
