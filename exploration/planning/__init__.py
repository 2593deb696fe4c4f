"""What is known so far, and which touch comes next.

The conductors (`explorer`, `any_form`, `survey`) stand in front. Behind them, in the order of imports: `ways`
through space, what is `known` of it, the `faces` that contacts lie on, what is still `open`, the pad `touching`,
the `moves` that close what is open, and `inferring` what no array could lie on.
"""
