from srmp._srmp import *
from srmp._srmp import __version__
