package vantage.spy;

/** The vectors that orientations can be applied to for a picture; the first is the paper's. */
enum RotatedVector {
  DIAGONAL("(1, 1, 1)/√3", 1, 1, 1),
  X("x axis", 1, 0, 0),
  Y("y axis", 0, 1, 0),
  Z("z axis", 0, 0, 1);

  private final String label;
  private final double[] direction;

  RotatedVector(String label, double... vector) {
    this.label = label;
    direction = Vectors.unit(vector);
  }

  /** Of unit length. */
  double[] direction() {
    return direction.clone();
  }

  @Override
  public String toString() {
    return label;
  }
}
