"""The documented random numbers: splitmix64 keys, Philox 4x32 with 10 rounds, Box-Muller.

From Salmon et al., "Parallel random numbers: as easy as 1, 2, 3" (SC 2011), and the key and
counter layout that the project's conventions state.
"""
import numpy as np

STREAM_SPECKLE, STREAM_NOISE, STREAM_SPLIT = 1, 2, 3
MASK_64 = (1 << 64) - 1


def mix64(value):
    """The finaliser of splitmix64 on a Python integer."""
    value = (value + 0x9E3779B97F4A7C15) & MASK_64
    value = ((value ^ (value >> 30)) * 0xBF58476D1CE4E5B9) & MASK_64
    value = ((value ^ (value >> 27)) * 0x94D049BB133111EB) & MASK_64
    return value ^ (value >> 31)


def stream_key(seed, stream, sequence):
    """key = mix(mix(seed) xor mix(not (stream 2^32 + sequence)))."""
    return mix64(mix64(seed & MASK_64) ^ mix64(~((stream << 32) + sequence) & MASK_64))


def philox_4x32(counter, key, rounds=10):
    """Four words per counter; counter is four equal-shaped uint32 arrays, key a 64-bit integer."""
    low_half = np.uint64(0xFFFFFFFF)
    words = [np.asarray(word).astype(np.uint64) for word in counter]
    key_words = [key & 0xFFFFFFFF, key >> 32]
    for _ in range(rounds):
        products = (words[0] * np.uint64(0xD2511F53), words[2] * np.uint64(0xCD9E8D57))
        high = [product >> np.uint64(32) for product in products]
        low = [product & low_half for product in products]
        words = [
            high[1] ^ words[1] ^ np.uint64(key_words[0]),
            low[1],
            high[0] ^ words[3] ^ np.uint64(key_words[1]),
            low[0],
        ]
        key_words = [
            (key_words[0] + 0x9E3779B9) & 0xFFFFFFFF,
            (key_words[1] + 0xBB67AE85) & 0xFFFFFFFF,
        ]
    return [word.astype(np.uint32) for word in words]


def complex_normals(key, ping, item, draw=0):
    """xi of unit mean square for 64-bit items: sqrt(-ln u0) exp(i 2 pi u1), complex128."""
    item = np.asarray(item, np.uint64)
    shape = np.zeros(item.shape, np.uint32)
    words = philox_4x32(
        (
            shape + np.uint32(ping),
            item & np.uint64(0xFFFFFFFF),
            item >> np.uint64(32),
            shape + np.uint32(draw),
        ),
        key,
    )
    uniform = [(word.astype(np.float64) + 0.5) / 2.0**32 for word in words[:2]]
    return np.sqrt(-np.log(uniform[0])) * np.exp(2j * np.pi * uniform[1])


def sample_noise(seed, sequence, ping, beams, samples, power_pa2):
    """Noise of one ping, complex128 [beams, samples], Pa."""
    item = (np.arange(beams, dtype=np.uint64)[:, None] << np.uint64(32)) + np.arange(
        samples, dtype=np.uint64
    )
    return np.sqrt(power_pa2) * complex_normals(
        stream_key(seed, STREAM_NOISE, sequence), ping, item
    )
