"""hooks"""
class MethodContract:
    """The laws of the package, as tests of one method; subclass it and name the ``method``.

    Attributes
    ----------
    method : Method
        With parameters that suit exemplars of 20 px a side; a patch of about 12.
    examples : int
        How many requests hypothesis draws for each law.
    least : int
        Shortest side, px, of the exemplars drawn.
    """

    method: ClassVar[Method]
    examples: ClassVar[int] = 10
    least: ClassVar[int] = 20

    # ---- what the laws use; a subclass may replace them -------------------------------------------------------

    def cases(self) -> SearchStrategy[Case]:
        """The requests on which the laws are tested."""
        return cases(self.method, least=self.least)

    def rim(self, exemplars: Sequence[Exemplar], size: tuple[int, int]) -> int:
        """How deep, in px, the method may replace what a start map holds: its overlap, 0 if it has none."""
        settled = self.method.settled(exemplars, Canvas(*size))
        return max(extent(getattr(settled, "overlap", 0)))

    def map_of_window(self, case: Case, box: Box) -> SourceMap:
        """Compute the map of a window alone, whatever lies around it; methods that claim WINDOW replace this."""
        raise NotImplementedError("a method that claims WINDOW says here how a window is computed alone")

    def for_all(self, law: Callable[[Case], None], examples: int | None = None) -> None:
        """Test a law on requests that hypothesis draws."""

        @settings(
            max_examples=examples or self.examples, deadline=None, derandomize=True, database=None,
            suppress_health_check=[HealthCheck.too_slow],
        )  # fmt: skip
        @given(self.cases())
        def check(case: Case) -> None:
            law(case)

        check()

    def claims(self, ability: Ability) -> None:
        """Skip the test of an ability that the method does not claim."""
        if ability not in self.method.supports:
            pytest.skip(f"{self.method.slug} does not claim {ability}")
