"""Networks: passes, derivatives, optimiser steps, and the units of their inputs and outputs."""
