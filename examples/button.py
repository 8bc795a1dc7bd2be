"""Button: while input D3 is high the shaft goes to 90 degrees for three seconds, else it rests at 0."""

from board import holding, move_to


def main() -> None:
    bench = holding()
    for at_s in range(12):
        pressed = at_s in (2, 7)
        bench.device("m1").pin("D3", int(pressed))
        if bench.axis("m1").snapshot().pin_d3:
            move_to(bench, 90)
            bench.run(ms=3000)
            print(f"{at_s:2d} s: pressed, {bench.axis('m1').snapshot().yw:6.2f} deg three seconds later")
            move_to(bench, 0)
        bench.run(ms=1000)
        print(f"{at_s:2d} s: {bench.axis('m1').snapshot().yw:6.2f} deg")


if __name__ == "__main__":
    main()
