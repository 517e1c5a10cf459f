package vantage.spy;

import java.util.Arrays;
import javax.swing.table.AbstractTableModel;

/** Rows for a JTable. */
final class RowsModel extends AbstractTableModel {
  private static final long serialVersionUID = 1;
  private transient Rows shown = new Rows("");

  /** Keeps the columns where their names stay the same. */
  void show(Rows rows) {
    boolean sameColumns = Arrays.equals(rows.columns(), shown.columns());
    shown = rows;
    if (sameColumns) {
      fireTableDataChanged();
    } else {
      fireTableStructureChanged();
    }
  }

  boolean isAlarm(int row) {
    return row < shown.rows().size() && shown.rows().get(row).alarm();
  }

  @Override
  public int getRowCount() {
    return shown.rows().size();
  }

  @Override
  public int getColumnCount() {
    return shown.columns().length;
  }

  @Override
  public String getColumnName(int column) {
    return shown.columns()[column];
  }

  @Override
  public Object getValueAt(int row, int column) {
    return shown.rows().get(row).cells()[column];
  }
}
