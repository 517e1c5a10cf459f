package vantage.spy;

import java.util.ArrayList;
import java.util.List;

/**
 * The contents of a table.
 *
 * @param title one line above it
 */
record Rows(String title, String[] columns, List<Row> rows) {
  static final int MAX_ROWS = 500;

  /**
   * One line of it.
   *
   * @param alarm something is wrong with what the line tells
   */
  record Row(boolean alarm, String... cells) {}

  Rows(String title, String... columns) {
    this(title, columns, new ArrayList<>());
  }

  /** Rows beyond MAX_ROWS are left out. */
  void add(boolean alarm, String... cells) {
    if (cells.length != columns.length) {
      throw new IllegalStateException(cells.length + " cells in " + columns.length + " columns");
    }
    if (rows.size() < MAX_ROWS) {
      rows.add(new Row(alarm, cells));
    }
  }
}
