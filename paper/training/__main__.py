"""python -m primfit.paper.training"""

from .running import main

if __name__ == "__main__":
    main()
