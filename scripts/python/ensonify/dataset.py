"""The reader of finished data sets, `ensonify_dataset`, under the name of this package."""
from ensonify_dataset import *  # noqa: F401,F403
from ensonify_dataset import __all__ as __all__
