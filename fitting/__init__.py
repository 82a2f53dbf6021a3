"""Geometry and estimation: five primitives, their refinement, and the pipeline that recognizes one."""
