"""The mask of echoes over mirrors."""
import numpy as np

import physics


def check_mask(checklist, ping, tie_margin, noise_margin_db):
    """The mask of bounced echoes, by the rule of most energy; noise forbids it like a label."""
    if "multipath" not in ping.masks:
        return
    wanted, sure = ping.expected.ghost, ping.expected.ghost_margin >= tie_margin
    noise = ping.sonar.noise_power_pa2
    if noise is not None:
        over_db = physics.power_level_db(ping.clean_pa2) - physics.power_level_db(noise)
        wanted = np.where(over_db >= 0.0, wanted, 0)
        sure &= np.abs(over_db) >= noise_margin_db
    wrong = np.count_nonzero((ping.masks["multipath"] != wanted) & sure)
    checklist.expect(
        wrong == 0,
        f"{ping.label} multipath mask, wrong pixels",
        wrong,
        f"0 ({np.count_nonzero(wanted)} labelled, {np.count_nonzero(~sure)} passed over)",
    )
